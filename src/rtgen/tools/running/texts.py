"""Texts of states and durations in reports of runs."""

from __future__ import annotations

from typing import Final

from rtgen.runtime import LifeCycleState

ERROR: Final = "ERROR"
FINISHED: Final = "finished"
"""What reports call ERROR where it is the end of a component's work."""
_UNITS: Final = (("s", 10**9), ("ms", 10**6), ("us", 10**3))


def name_of(state: LifeCycleState) -> str:
    """Return the name of a state in reports and conditions."""
    return state.name.removesuffix("_STATE")


def duration(time: int) -> str:
    """Return a duration, given in ns, as people write it: `3.02 s`, `20 ms`, `85 us`."""
    for unit, size in _UNITS:
        value = float(f"{time / size:.3g}")
        if value >= 1.0:
            return f"{value:.10g} {unit}"
    return f"{time} ns"
