"""Time-out of tests that wait for something. It is only reached if a test fails."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

PATIENCE = 120.0
"""In seconds; long, since a loaded machine is slow."""
_PERIOD = 0.01
"""Between two looks [s]."""


def until(
    condition: Callable[[], Any],
    patience: float = PATIENCE,
    shown: Callable[[], object] = lambda: "it did not happen",
) -> Any:
    """Return the value of a condition, once it is true.

    Raises AssertionError with what `shown` returns if it is not true after `patience` seconds.
    """
    end = time.monotonic() + patience
    while not (value := condition()):
        assert time.monotonic() < end, shown()
        time.sleep(_PERIOD)
    return value
