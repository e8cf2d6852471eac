"""Nodes of ROS 2 side by side: written by hand with rclpy, `--ros2 rclpy`, and `--ros2 dds`.

    python benchmarks/ros2.py

What a driver sends on one topic comes back on another: by rclpy's executor and a callback, or by an
InPort and an OutPort of rtgen. Messages are decoded, changed and encoded again. The driver is the
same for all, a node of rclpy on Fast DDS. Latency is that of the way there and back, `cpu` the
processor time of the node for each message, `found` the time until a node that starts gets the
first message. With clouds and with mixed QoS it is the time until a driver that joins late gets a
message of the same size that was sent once (transient local). With mixed QoS, readers are best
effort and writers reliable. Rounds alternate; figures are medians of rounds.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

from tables import Arguments, Results

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from media import own_domain  # noqa: E402
from ros2_peers import DISTRIBUTIONS, Installation, make  # noqa: E402

ENDS = HERE / "ros2_ends.py"
KINDS = ("hand", "rclpy", "dds")
ROUNDS = 5


class Load(NamedTuple):
    """Messages of a type: how many in a round, how many a second, the octets of their data, QoS."""

    title: str
    type: str
    count: int
    rate: float
    octets: int
    qos: str = "reliable"


LOADS = (
    Load("1 kHz odometry", "nav_msgs/msg/Odometry", 3000, 1000.0, 0),
    Load("10 MB clouds", "sensor_msgs/msg/PointCloud2", 10, 2.0, 10_000_000, "late"),
    Load("mixed QoS", "nav_msgs/msg/Odometry", 1000, 200.0, 0, "mixed"),
)


class Figures(NamedTuple):
    """Those of one round: times in milliseconds, `found` in seconds, `came` as a share."""

    latency: float
    worst: float
    cpu: float
    found: float
    came: float


def start(python: str, ros2: Installation, domain: int, *words: str) -> Any:
    """Start one of the ends."""
    return subprocess.Popen(
        [python, str(ENDS), *words],
        env=ros2.environment(domain),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def line(process: Any, text: str | None = None) -> Any:
    """Write a line, if any; return the next one that the process writes."""
    if text is not None:
        print(text, file=process.stdin, flush=True)
    return process.stdout.readline()


def measured(ros2: Installation, kind: str, load: Load) -> Figures:
    """Run a node and the driver."""
    domain = own_domain()
    python = sys.executable if kind == "dds" else ros2.python
    octets = str(load.octets), load.qos
    node = start(python, ros2, domain, "echo", kind, load.type, *octets)
    line(node)
    words = load.type, str(load.count), str(load.rate), *octets
    driver = start(ros2.python, ros2, domain, "drive", *words)
    try:
        found = json.loads(line(driver))["found"]
        before = float(line(node, "cpu"))
        latencies = json.loads(line(driver, "go"))["latencies"]
        used = float(line(node, "cpu")) - before
    finally:
        for process in (driver, node):
            process.kill()
            process.communicate()
    return Figures(
        statistics.median(latencies) if latencies else float("nan"),
        latencies[int(len(latencies) * 0.99)] if latencies else float("nan"),
        used * 1e3 / load.count,
        found,
        len(latencies) / load.count,
    )


def main() -> None:
    """Print the table."""
    chosen = Arguments(__doc__, rounds=ROUNDS).parse_args()
    with Results(__file__, chosen) as results:
        table = results.table(
            "nodes",
            "messages, node",
            ("there and back [ms]", ".2f"),
            ("99 % [ms]", ".2f"),
            ("processor time [ms]", ".3f"),
            ("found [s]", ".2f"),
            ("came", ".1%"),
        )
        for distribution in DISTRIBUTIONS[:1] if chosen.smallest else DISTRIBUTIONS:
            ros2 = make(distribution)
            for load in LOADS[:1] if chosen.smallest else LOADS:
                rounds = [
                    [measured(ros2, kind, load) for kind in KINDS]
                    for _ in range(chosen.rounds)
                ]
                for kind, each in zip(KINDS, zip(*rounds, strict=True), strict=True):
                    figures = map(statistics.median, zip(*each, strict=True))
                    table.add(f"{distribution}, {load.title}, {kind}", *figures)


if __name__ == "__main__":
    main()
