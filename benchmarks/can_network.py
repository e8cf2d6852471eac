"""Simulation of a full CANopen bus: 126 slaves and the manager, 1 Mbit/s, SYNC each 100 ms.

    python benchmarks/can_network.py [--seconds S]

Every slave sends a PDO at each SYNC and receives that of another slave; heartbeats are each second.
The output is simulated seconds for each second of processor time, for booting and for running.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from tables import Arguments, Results

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/runtime/canopen"))

from full_network import FullNetwork

BOOTED = 3.0
"""Simulated seconds until all nodes are configured and run."""


def main() -> None:
    """Run for the given time, by default a minute."""
    parser = Arguments(__doc__, rounds=1)
    parser.add_argument("--seconds", type=float, default=60.0)
    chosen = parser.parse_args()
    if chosen.smallest:
        chosen.seconds = 0.1
    network = FullNetwork()
    before = 0
    with Results(__file__, chosen) as results:
        table = results.table(
            "bus",
            "126 slaves",
            ("simulated [s]", ".1f"),
            ("frames", ",d"),
            ("times real time", ".1f"),
            ("a frame [µs]", ".1f"),
        )
        for name, start, end in (
            ("boot", 0.0, BOOTED),
            ("run", BOOTED, BOOTED + chosen.seconds),
        ):
            begin = time.process_time()
            network.run(end)
            taken = time.process_time() - begin
            frames, before = network.collector.frames - before, network.collector.frames
            ratio = (end - start) / taken
            table.add(name, end - start, frames, ratio, taken / frames * 1e6)
    print(f"lost or doubled samples: {network.lost_or_doubled()}")


if __name__ == "__main__":
    main()
