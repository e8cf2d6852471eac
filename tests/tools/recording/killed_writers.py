"""Forks writers of recordings and kills each at a random moment: FOLDER COUNT SEED."""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path

from recorded_runs import MS, counting

from rtgen.tools.recording import mcap_writer
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder

MAX_DELAY = 0.04
"""Maximum time until a writer is killed [s]."""


def write(path: Path, ready: int) -> None:
    with McapWriter(path) as writer, counting() as system:
        Recorder(system, writer)
        os.write(ready, b".")
        system.run(3_600_000 * MS)


def main(folder: Path, count: int, seed: int) -> None:
    mcap_writer.CHUNK = 1 << 12
    draw = random.Random(seed)
    for number in range(count):
        reading, ready = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                write(folder / f"{number}.mcap", ready)
            finally:
                os._exit(1)
        os.read(reading, 1)
        time.sleep(draw.uniform(0.0, MAX_DELAY))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        assert os.WTERMSIG(status) == signal.SIGKILL
        os.close(reading)
        os.close(ready)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
