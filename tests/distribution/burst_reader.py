"""A process that counts samples over DDS: PARTITION. It prints a line for each `EACH` of them."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from media import DOMAIN

from refrobots import rtc
from rtgen.runtime.distribution.medium import Qos, Topic

EACH = 300
TOPIC = Topic("t", rtc.TimedLong)
QOS = Qos(reliable=False, depth=5000)


def main(partition: str) -> None:
    """Count without end."""
    from rtgen.runtime.dds.medium import DdsMedium

    count = 0

    def on_sample(_: object) -> None:
        nonlocal count
        count += 1
        if count % EACH == 0:
            print(EACH, flush=True)

    DdsMedium(partition, domain=DOMAIN).subscribe(TOPIC, QOS, on_sample)
    print("ready", flush=True)
    threading.Event().wait()


if __name__ == "__main__":
    main(sys.argv[1])
