"""The benchmark of real time runs, with its smallest rounds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

BENCHMARK = Path(__file__).parents[3] / "benchmarks" / "realtime.py"


def test_the_benchmark_measures_each_kind() -> None:
    command = [sys.executable, str(BENCHMARK), "--smallest"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    _, *rows = [row for row in done.stdout.splitlines() if "left out" not in row]
    assert [row.split()[:3] for row in rows] == [
        [count, "100", kind]
        for count in ("1", "3")
        for kind in ("shared", "own", "relays", "loop")
    ]
