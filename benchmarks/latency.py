"""Latency of chains of components in one process, in every order in which they can be added.

    python benchmarks/latency.py [--seconds S]

A source at 100 Hz, and chains of 2, 4 and 6 components behind it that pass its samples on; the last
one takes the time from `write` of the first to its `read`. `periodic`: components that tick, all at
100 Hz; `arrival`: components that samples execute; `own`: those with a thread each; `rclpy`:
callbacks of one node of ROS 2 in its executor, if it is installed. Each order of `add` is a run of
its own, random ones of those of more than four. Figures are in microseconds: the median and the
99th percentile of the samples of the best and of the worst order, and the worst median by hop.
"""

from __future__ import annotations

import random
import statistics
from itertools import permutations
from pathlib import Path

from kinds import of_rclpy, of_rtgen
from tables import Arguments, Results

ENDS = Path(__file__).with_name("latency_ends.py")
LENGTHS = (2, 4, 6)
MOST_ORDERS = 24


def orders(length: int, most: int) -> list[tuple[int, ...]]:
    """Return orders of `add` of a chain and its source: all, or random ones."""
    every = list(permutations(range(length + 1)))
    if len(every) <= most:
        return every
    chosen = random.Random(1).sample(every, most - 2)
    return [every[0], every[-1], *chosen]


def main() -> None:
    """Print a table of all chains."""
    parser = Arguments(__doc__, rounds=1)
    parser.add_argument("--seconds", type=float, default=1.0)
    chosen = parser.parse_args()
    kinds = [*of_rtgen("periodic", "arrival", "own")]
    if chosen.smallest:
        chosen.seconds = 0.1
    else:
        kinds += of_rclpy()
    with Results(__file__, chosen) as results:
        table = results.table(
            "orders",
            "components, kind",
            ("orders", "d"),
            ("best, median [µs]", ".0f"),
            ("99 % [µs]", ".0f"),
            ("worst, median [µs]", ".0f"),
            ("99 % [µs]", ".0f"),
            ("worst, a hop [µs]", ".0f"),
        )
        for length in LENGTHS[:1] if chosen.smallest else LENGTHS:
            for kind in kinds:
                taken = orders(length, 2 if chosen.smallest else MOST_ORDERS)
                found = []
                for order in taken if kind.name != "rclpy" else taken[:1]:
                    text = ",".join(map(str, order))
                    rounds = [
                        kind.figures(ENDS, chosen.seconds, text)
                        for _ in range(chosen.rounds)
                    ]
                    found.append(
                        tuple(map(statistics.median, zip(*rounds, strict=True)))
                    )
                best, worst = min(found), max(found)
                title = f"{length}, {kind.name}"
                table.add(title, len(found), *best, *worst, worst[0] / length)


if __name__ == "__main__":
    main()
