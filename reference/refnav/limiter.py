"""Limiter of speed and acceleration, shared by the control law and the wheels."""

from __future__ import annotations


def limited(value: float, target: float, most: float, step: float) -> float:
    """Return the next value on the way to `target`.

    It is within [-most, most], unless the value before is farther out than one step, and at most
    `step` away from `value`. `most` and `step` are not negative; all in one unit.
    """
    if target > most:
        target = most
    elif target < -most:
        target = -most
    if target > value + step:
        return value + step
    if target < value - step:
        return value - step
    return target
