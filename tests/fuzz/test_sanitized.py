"""The codecs in C with the sanitizers of gcc, on changed octets of all types."""

from __future__ import annotations

import subprocess
import sys

import pytest
import sanitized

BEYOND = """
import ctypes
allocate = ctypes.CDLL(None).malloc
allocate.restype = ctypes.c_void_p
ctypes.memset(allocate(8), 0, 9)
"""

pytestmark = [pytest.mark.nightly, pytest.mark.slow]


@pytest.fixture(scope="module")
def environment() -> dict[str, str]:
    """Build the module with the sanitizers."""
    try:
        return sanitized.environment()
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"gcc with its sanitizers is missing: {error}")


def run(environment: dict[str, str], *words: str) -> tuple[int, str]:
    """Run a program of Python with the sanitizers; return exit code and output."""
    done = subprocess.run(
        [sys.executable, *words],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


def test_octets_beyond_a_block_are_reported(environment: dict[str, str]) -> None:
    code, report = run(environment, "-c", BEYOND)
    assert code != 0
    assert "heap-buffer-overflow" in report


def test_changed_octets_are_read_within_their_blocks(
    environment: dict[str, str],
) -> None:
    code, report = run(environment, sanitized.__file__, "--seconds", "5")
    assert code == 0, report
    assert "inputs without a finding" in report
