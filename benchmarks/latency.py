"""Latency of chains of components in one process, in every order in which they can be added.

    python benchmarks/latency.py [--rounds N] [--seconds S] [--smallest]

A source at 100 Hz, and chains of 2, 4 and 6 components behind it that pass its samples on; the last
one takes the time from `write` of the first to its `read`. `periodic`: components that tick, all at
100 Hz; `arrival`: components that samples execute; `own`: those with a thread each; `rclpy`:
callbacks of one node of ROS 2 in its executor, if it is installed. Each order of `add` is a run of
its own, random ones of those of more than four. Figures are in microseconds: the median and the
99th percentile of the samples of the best and of the worst order, and the worst median by hop.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
from collections.abc import Iterator
from itertools import permutations
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

ENDS = HERE / "latency_ends.py"
LENGTHS = (2, 4, 6)
MOST_ORDERS = 24


def kinds(*, smallest: bool) -> Iterator[tuple[str, str, dict[str, str]]]:
    """Yield the kinds that can be measured, with their interpreters and environments."""
    for kind in ("periodic", "arrival", "own"):
        yield kind, sys.executable, dict(os.environ)
    if smallest:
        return
    from media import own_domain
    from ros2_peers import DISTRIBUTIONS, make

    ros2 = make(DISTRIBUTIONS[0])
    if isinstance(ros2, str):
        print(f"rclpy is left out: {ros2}")
    else:
        yield "rclpy", ros2.python, ros2.environment(own_domain())


def orders(length: int, most: int) -> list[tuple[int, ...]]:
    """Return orders of `add` of a chain and its source: all, or random ones."""
    every = list(permutations(range(length + 1)))
    if len(every) <= most:
        return every
    chosen = random.Random(1).sample(every, most - 2)
    return [every[0], every[-1], *chosen]


def main() -> None:
    """Print a table of all chains."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument(
        "--smallest", action="store_true", help="two orders, without peers"
    )
    options = parser.parse_args()
    if options.smallest:
        options.seconds = 0.1
    every = list(kinds(smallest=options.smallest))
    print("chain  kind      orders  best [us]    99 %  worst [us]    99 %  worst a hop")
    for length in LENGTHS[:1] if options.smallest else LENGTHS:
        for kind, python, environment in every:
            chosen = orders(length, 2 if options.smallest else MOST_ORDERS)
            found: list[tuple[float, float]] = []
            for order in chosen if kind != "rclpy" else chosen[:1]:
                command = [python, str(ENDS), kind, str(options.seconds)]
                command.append(",".join(map(str, order)))
                rounds = [
                    json.loads(
                        subprocess.run(
                            command,
                            env=environment,
                            stdout=subprocess.PIPE,
                            text=True,
                            check=True,
                        ).stdout
                    )
                    for _ in range(options.rounds)
                ]
                middle, late = zip(*rounds, strict=True)
                found.append((statistics.median(middle), statistics.median(late)))
            best, worst = min(found), max(found)
            print(
                f"{length:5}  {kind:9} {len(found):6} {best[0]:10.0f} {best[1]:7.0f}"
                f" {worst[0]:11.0f} {worst[1]:7.0f} {worst[0] / length:12.0f}"
            )


if __name__ == "__main__":
    main()
