"""Latency of chains of components: in one process in any order, and in two beside the libraries.

    python benchmarks/latency.py [--seconds S]

A source at 100 Hz, and chains of 2, 4 and 6 components behind it that pass its samples on; the last
one takes the time from `write` of the first to its `read`.

In one process: `periodic`, components that tick, all at 100 Hz; `arrival`, components that samples
execute; `own`, those with a thread each; `rclpy`, callbacks of one node of ROS 2 in its executor,
if it is installed. Each order of `add` is a run of its own, random ones of those of more than four.
Figures are in microseconds: the median and the 99th percentile of the samples of the best and of
the worst order, and the worst median by hop.

In two processes, in turns, so that each hop is one between processes: components that samples
execute over DDS, Zenoh and CORBA; rtgen's publishers and subscriptions without components; and
beside them the same by cyclonedds-python, zenoh-python and omniORBpy alone, and by rclpy
(`hops_ends.py`). Latency and processor time of both processes are
those of a hop. Rounds of all alternate, each in new processes; figures are medians of rounds.
"""

from __future__ import annotations

import json
import os
import random
import statistics
import subprocess
from contextlib import nullcontext
from itertools import permutations
from pathlib import Path
from typing import Any

from kinds import Kind, of_rclpy, of_rtgen
from media import transports
from tables import Arguments, Results, Table

ENDS = Path(__file__).with_name("latency_ends.py")
HOPS = Path(__file__).with_name("hops_ends.py")
ENGINES = {"dds": "cyclonedds-python", "zenoh": "zenoh-python", "corba": "omniORBpy"}
LENGTHS = (2, 4, 6)
MOST_ORDERS = 24


def orders(length: int, most: int) -> list[tuple[int, ...]]:
    """Return orders of `add` of a chain and its source: all, or random ones."""
    every = list(permutations(range(length + 1)))
    if len(every) <= most:
        return every
    chosen = random.Random(1).sample(every, most - 2)
    return [every[0], every[-1], *chosen]


def in_one_process(kinds: list[Kind], chosen: Any, table: Table) -> None:
    """Fill the table of all orders of chains in one process."""
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
                found.append(tuple(map(statistics.median, zip(*rounds, strict=True))))
            best, worst = min(found), max(found)
            title = f"{length}, {kind.name}"
            table.add(title, len(found), *best, *worst, worst[0] / length)


def hops(kind: Kind, transport: str, length: int, seconds: float) -> tuple[float, ...]:
    """Return median and 99 % of the latency of a hop, and its processor time, all in us."""
    with transports(transport) if transport else nullcontext() as network:
        processes: list[subprocess.Popen[str]] = []
        try:
            for number in (0, 1):
                place = "" if network is None else network.address
                words = kind.name, number, length, seconds, place
                processes.append(
                    subprocess.Popen(
                        [kind.python, str(HOPS), *map(str, words)],
                        env=kind.environment,
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        text=True,
                    )
                )
                _await(processes[-1], "open")
            for process in processes:
                _await(process, "ready")
            for process in processes:
                _say(process)
            assert processes[0].stdout is not None
            ours = json.loads(processes[0].stdout.readline())
            _say(processes[1])
            assert processes[1].stdout is not None
            theirs = json.loads(processes[1].stdout.readline())
        finally:
            for process in processes:
                process.kill()
                process.communicate()
    each = sorted(value / length for value in ours["latencies"])
    used = (ours["processor"] + theirs["processor"]) * 1e6 / len(each) / length
    return each[len(each) // 2], each[int(len(each) * 0.99)], used


def _await(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    if line != word:
        raise SystemExit(f"{process.args}: {line!r} instead of {word!r}")


def _say(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    process.stdin.write("go\n")
    process.stdin.flush()


def in_two_processes(rclpy: list[Kind], chosen: Any, table: Table) -> None:
    """Fill the table of hops between two processes."""
    ours, engine = of_rtgen("rtgen", "engine")
    cases = [
        (title, kind, transport)
        for transport, library in ENGINES.items()
        for title, kind in (
            (f"{transport}, components", ours),
            (f"{transport}, rtgen's engine", engine),
            (library, Kind(transport, ours.python, dict(os.environ))),
        )
    ]
    cases += [("rclpy, Fast DDS", each, "") for each in rclpy]
    for length in LENGTHS[:1] if chosen.smallest else LENGTHS:
        rounds = [
            [
                hops(kind, transport, length, chosen.seconds)
                for _, kind, transport in cases
            ]
            for _ in range(chosen.rounds)
        ]
        for (title, _, _), each in zip(cases, zip(*rounds, strict=True), strict=True):
            figures = map(statistics.median, zip(*each, strict=True))
            table.add(f"{length}, {title}", *figures)


def main() -> None:
    """Print the tables of both."""
    parser = Arguments(__doc__, rounds=3)
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--only", choices=("one", "two"), help="number of processes")
    chosen = parser.parse_args()
    kinds = [*of_rtgen("periodic", "arrival", "own")]
    rclpy: list[Kind] = []
    if chosen.smallest:
        chosen.seconds = 0.1
    else:
        rclpy = [*of_rclpy()]
    with Results(__file__, chosen) as results:
        if chosen.only != "two":
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
            in_one_process([*kinds, *rclpy], chosen, table)
        if chosen.only != "one":
            table = results.table(
                "hops",
                "hops, by",
                ("a hop, median [µs]", ".0f"),
                ("99 % [µs]", ".0f"),
                ("processor time [µs]", ".0f"),
            )
            in_two_processes(rclpy, chosen, table)


if __name__ == "__main__":
    main()
