"""Freed memory is used again: the kernel clears no pages for later blocks of the same size."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys

import pytest

if sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "mallopt"):
    pytest.skip("glibc has mallopt", allow_module_level=True)

PR_SET_THP_DISABLE = 41
BLOCKS = f"""
import ctypes, resource
from rtgen.runtime.freed_memory import keep_freed_memory
ctypes.CDLL(None).prctl({PR_SET_THP_DISABLE}, 1, 0, 0, 0)  # huge pages hide the faults
keep_freed_memory()
def use():
    blocks = [bytearray(b"x") * size for size in (10_000_000, 9_999_000, 10_001_000)]
use()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    use()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
PAGES = 10 * 3 * 10_000_000 // os.sysconf("SC_PAGESIZE")
"""Of all blocks."""


def faults(**more: str) -> int:
    """Return the number of page faults for the blocks."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("MALLOC_", "GLIBC_"))
    }
    command = [sys.executable, "-c", BLOCKS]
    output = subprocess.run(
        command, env=environment | more, stdout=subprocess.PIPE, check=True
    ).stdout
    return int(output)


def test_blocks_of_some_megabytes_take_no_new_pages() -> None:
    assert faults() < PAGES / 10


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "option",
    [
        ("MALLOC_MMAP_THRESHOLD_", "100000"),
        ("GLIBC_TUNABLES", "glibc.malloc.mmap_threshold=100000"),
    ],
)
def test_options_of_the_user_stay(option: tuple[str, str]) -> None:
    name, value = option
    assert faults(**{name: value}) > PAGES / 2
