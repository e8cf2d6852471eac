"""The benchmark of values runs, on some of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import speed

ROOT = Path(__file__).parents[3]


@pytest.mark.nightly
@pytest.mark.peer
def test_times_of_values_beside_peers() -> None:
    pytest.importorskip("omniORB")
    speed.module()
    variables = {**os.environ, "RTGEN_CODEC": "c", "PYTHONPATH": str(speed.FOLDER)}
    command = [sys.executable, str(ROOT / "benchmarks" / "values.py")]
    printed = subprocess.run(
        [*command, "fixed", "any of a string", "mutable"],
        capture_output=True,
        text=True,
        check=True,
        env=variables,
    ).stdout
    lines = {line[:18].strip(): line for line in printed.splitlines()}
    assert lines.keys() == {"fixed", "any of a string", "mutable"}
    assert all("in Python" in line for line in lines.values())
    assert "omniORBpy" in lines["fixed"]
