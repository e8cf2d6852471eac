"""Faults at each step of writing an output folder, in a process of their own."""

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("fault", "least"), [("kill", 20), ("full", 5), ("readonly", 2)]
)
def test_faults(fault: str, least: int) -> None:
    script = Path(__file__).with_name("write_faults.py")
    done = subprocess.run(
        [sys.executable, script, fault],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= least
