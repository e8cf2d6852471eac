"""When the values of samples and calls are checked in one process, where nothing encodes them."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class CheckValues(StrEnum):
    """`first`: the first values of each port and operation, then one in each `PERIOD`."""

    ALWAYS = "always"
    FIRST = "first"
    NEVER = "never"


FIRST_VALUES: Final = 100
"""Values of each port and operation that `first` checks at the beginning."""

PERIOD: Final = 100_000_000
"""Simulated time after which `first` checks another value, in ns."""


def count_of(check: CheckValues) -> float:
    """Return the number of values to check before the first period."""
    return {
        CheckValues.ALWAYS: float("inf"),
        CheckValues.FIRST: FIRST_VALUES,
        CheckValues.NEVER: 0,
    }[check]
