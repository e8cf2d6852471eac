"""Freed memory is used again: the kernel clears no pages for later blocks of the same size.

Each engine that carries large messages to other processes asks for that.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys

import pytest

if sys.platform != "linux" or not hasattr(ctypes.CDLL(None), "mallopt"):
    pytest.skip("glibc has mallopt", allow_module_level=True)

PR_SET_THP_DISABLE = 41
ENGINES = {
    "cyclonedds": """
from rtgen.runtime.dds.medium import DdsMedium
opened = DdsMedium("freed", domain=91)
""",
    "zenoh": """
from rtgen.runtime.zenoh.medium import ZenohMedium
from rtgen.runtime.zenoh.session import Endpoints
opened = ZenohMedium("freed", Endpoints(listen=("tcp/127.0.0.1:0",)))
""",
    "omniORB": """
from rtgen.runtime.corba.orb import Orb
opened = Orb()
""",
}
"""What opens an engine, by the library that it needs."""
BLOCKS = f"""
import ctypes, resource
ctypes.CDLL(None).prctl({PR_SET_THP_DISABLE}, 1, 0, 0, 0)  # huge pages hide the faults
def use():
    blocks = [bytearray(b"x") * size for size in (10_000_000, 9_999_000, 10_001_000)]
use()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    use()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
KEEP = """
from rtgen.runtime.freed_memory import keep_freed_memory
keep_freed_memory()
"""
PAGES = 10 * 3 * 10_000_000 // os.sysconf("SC_PAGESIZE")
"""Of all blocks."""


def faults(before: str = KEEP, after: str = "", **more: str) -> int:
    """Return the number of page faults for the blocks, in a process that has run `before`."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("MALLOC_", "GLIBC_"))
    }
    command = [sys.executable, "-c", before + BLOCKS + after]
    output = subprocess.run(
        command, env=environment | more, stdout=subprocess.PIPE, check=True
    ).stdout
    return int(output)


def test_blocks_of_some_megabytes_take_no_new_pages() -> None:
    assert faults() < PAGES / 10


@pytest.mark.parametrize("library", ENGINES)
def test_each_engine_asks_for_it(library: str) -> None:
    pytest.importorskip(library)
    assert faults(ENGINES[library], "opened.close()\n") < PAGES / 10


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
