"""A process that reads bursts over DDS: PARTITION RELIABILITY.

It prints `begin` for the first 0 since a burst, and the number of samples of a burst after its
last one, `EACH`.
"""

from __future__ import annotations

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from media import DOMAIN

from refrobots import rtc
from rtgen.runtime.distribution.medium import Qos, Sample, Topic
from rtgen.runtime.xcdr import deserialize

EACH = 300
TOPIC = Topic("t", rtc.TimedLong)
QOS = {
    "best_effort": Qos(reliable=False, depth=5000),
    "reliable": Qos(depth=None, patience=60),
}


class Bursts:
    """Counts the samples of a burst."""

    def __init__(self) -> None:
        self._count: int | None = None

    def on_sample(self, sample: Sample) -> None:
        """Print a line at the begin and at the end of a burst."""
        number = deserialize(rtc.TimedLong, sample.octets).data
        if not number:
            if self._count is None:
                print("begin", flush=True)
            self._count = 0
        elif self._count is not None:
            self._count += 1
            if number == EACH:
                print(self._count, flush=True)
                self._count = None


if __name__ == "__main__":
    from rtgen.runtime.dds.medium import DdsMedium

    partition, reliability = sys.argv[1:]
    medium = DdsMedium(partition, domain=DOMAIN)
    medium.subscribe(TOPIC, QOS[reliability], Bursts().on_sample)
    print("ready", flush=True)
    threading.Event().wait()
