"""Simulation of a full CANopen bus: 126 slaves and the manager, 1 Mbit/s, SYNC each 100 ms.

    python benchmarks/can_network.py [SECONDS]

Every slave sends a PDO at each SYNC and receives that of another slave; heartbeats are each second.
The output is simulated seconds for each second of processor time, for booting and for running.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/runtime/canopen"))

from full_network import FullNetwork

BOOTED = 3.0
"""Simulated seconds until all nodes are configured and run."""


def main() -> None:
    """Run for the given time, by default a minute."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    network = FullNetwork()
    print(f"{'':10}{'simulated [s]':>14}{'frames':>10}{'ratio':>8}{'us/frame':>10}")
    before = 0
    for name, start, end in (
        ("boot", 0.0, BOOTED),
        ("run", BOOTED, BOOTED + seconds),
    ):
        begin = time.process_time()
        network.run(end)
        taken = time.process_time() - begin
        frames, before = network.collector.frames - before, network.collector.frames
        print(
            f"{name:10}{end - start:14.1f}{frames:10}{(end - start) / taken:8.1f}"
            f"{taken / frames * 1e6:10.1f}"
        )
    print(f"lost or doubled samples: {network.lost_or_doubled()}")


if __name__ == "__main__":
    main()
