"""The benchmarks of real time run, with their smallest rounds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parents[3] / "benchmarks"


def rows(name: str) -> list[list[str]]:
    """Return the rows of the table that a benchmark prints."""
    command = [sys.executable, str(FOLDER / name), "--smallest"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [row.split() for row in done.stdout.splitlines()[1:]]


def test_each_kind_of_ticks_is_measured() -> None:
    assert [row[:3] for row in rows("realtime.py")] == [
        [count, "100", kind]
        for count in ("1", "3")
        for kind in ("shared", "own", "relays", "loop")
    ]


def test_each_kind_of_chains_is_measured() -> None:
    assert [row[:3] for row in rows("latency.py")] == [
        ["2", kind, "2"] for kind in ("periodic", "arrival", "own")
    ]
