"""Freed memory that the process keeps for large messages.

glibc returns blocks of some megabytes to the system, which clears the pages of the next ones: for a
message of 10 MB that takes longer than to copy it several times.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from typing import Final

_OPTIONS: Final = (
    ("MALLOC_MMAP_THRESHOLD_", "glibc.malloc.mmap_threshold", -3, 32 << 20),
    ("MALLOC_TRIM_THRESHOLD_", "glibc.malloc.trim_threshold", -1, 128 << 20),
)
"""Variables of the environment, tunables, and numbers of options of mallopt(3), with their values.

Blocks of up to 32 MiB, glibc's limit for this option, are taken from memory that was freed before,
of which a heap keeps 128 MiB.
"""


@cache
def keep_freed_memory() -> None:
    """Keep freed memory, on Linux with glibc, unless the environment has an option for that."""
    if sys.platform != "linux":
        return
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    tunables = os.environ.get("GLIBC_TUNABLES", "")
    if mallopt is None or any(
        variable in os.environ or tunable in tunables
        for variable, tunable, _, _ in _OPTIONS
    ):
        return
    for _, _, option, octets in _OPTIONS:
        mallopt(option, octets)
