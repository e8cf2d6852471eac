"""UTC that never jumps: it is set once, and then follows the monotonic clock."""

from __future__ import annotations

import time

_OFFSET = time.time_ns() - time.monotonic_ns()


def steady_utc() -> int:
    """Return UTC [ns], as the machine had it at the start of the process."""
    return time.monotonic_ns() + _OFFSET
