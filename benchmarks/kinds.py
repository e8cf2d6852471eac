"""The kinds of ends that `latency.py` and `realtime.py` measure, each in a process of its own."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))


class Kind(NamedTuple):
    """A kind, with the interpreter and the environment that it needs."""

    name: str
    python: str
    environment: Mapping[str, str]

    def figures(self, script: Path, *arguments: object) -> Any:
        """Return what a script writes as JSON in the last line of its output."""
        done = subprocess.run(
            [self.python, str(script), self.name, *map(str, arguments)],
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=600,
        )
        return json.loads(done.stdout.splitlines()[-1])


def of_rtgen(*names: str) -> Iterator[Kind]:
    """Yield kinds of this interpreter."""
    for name in names:
        yield Kind(name, sys.executable, dict(os.environ))


def of_rclpy() -> Iterator[Kind]:
    """Yield rclpy, if it can be installed."""
    from media import own_domain
    from ros2_peers import DISTRIBUTIONS, make

    ros2 = make(DISTRIBUTIONS[0])
    if isinstance(ros2, str):
        print(f"rclpy is left out: {ros2}")
    else:
        yield Kind("rclpy", ros2.python, ros2.environment(own_domain()))


def of_openrtm() -> Iterator[Kind]:
    """Yield OpenRTM-aist-Python, if it is installed."""
    if importlib.util.find_spec("OpenRTM_aist") is None:
        print("openrtm is left out: OpenRTM_aist is not installed")
    else:
        yield from of_rtgen("openrtm")
