"""Parses constants and defaults in ROS 2 interface files."""

from __future__ import annotations

import math
import re
from typing import Final, TypeAlias

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES, Primitive

Scalar: TypeAlias = bool | int | float | str
Value: TypeAlias = Scalar | tuple[Scalar, ...]

_BOOLEANS: Final = {"true": True, "1": True, "false": False, "0": False}
_QUOTED: Final = re.compile(
    r"""\s*("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*'|[^,"']*)\s*(,|$)"""
)


def parsed(
    text: str, kind: Primitive | None, *, many: bool, verbatim: bool = False
) -> Value:
    """Parse a value; `kind` None is a string. Raises ValueError with the reason."""
    if not many:
        return _scalar(text, kind, verbatim)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError("is not written as [a, b]")
    inner = text[1:-1].strip()
    found: list[Scalar] = []
    at = 0
    while at < len(inner):
        match = _QUOTED.match(inner, at)
        if match is None:
            raise ValueError("has a quote that is not closed")
        found.append(_scalar(match[1].strip(), kind, verbatim=False))
        at = match.end()
    return tuple(found)


def _scalar(text: str, kind: Primitive | None, verbatim: bool) -> Scalar:
    if kind is None:
        return _string(text, verbatim)
    if kind is Primitive.BOOLEAN:
        value = _BOOLEANS.get(text.lower())
        if value is None:
            raise ValueError("is neither true nor false")
        return value
    if kind in FLOAT_LIMITS:
        return _real(text, kind)
    try:
        number = int(text, 0)
    except ValueError:
        raise ValueError("is not an integer") from None
    lowest, highest = INTEGER_RANGES[kind]
    if not lowest <= number <= highest:
        raise ValueError(f"is not in {lowest} to {highest}")
    return number


def _real(text: str, kind: Primitive) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError("is not a number") from None
    if math.isfinite(number) and abs(number) > FLOAT_LIMITS[kind]:
        raise ValueError("is too large for float32")
    return number


def _string(text: str, verbatim: bool) -> str:
    for quote in "\"'":
        if text.startswith(quote):
            if len(text) < 2 or not text.endswith(quote):
                raise ValueError("has a quote that is not closed")
            return re.sub(r"\\(.)", r"\1", text[1:-1])
    if text.endswith(('"', "'")) and not verbatim:
        raise ValueError("has a quote that is not opened")
    return text
