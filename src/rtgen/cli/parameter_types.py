"""Types of options: places, ranges of numbers."""

from __future__ import annotations

import math
from typing import Any

import click

_PORTS = 1 << 16


def _in_words(minimum: float | None, maximum: float | None, *, is_open: bool) -> str:
    """Return a range in words, for help and messages (click writes `0<=x<=5`)."""
    if minimum is None:
        return "" if maximum is None else f"at most {maximum:.10g}"
    above = f"above {minimum:.10g}" if is_open else f"{minimum:.10g}"
    if maximum is None:
        return above if is_open else f"at least {above}"
    return f"{above} to {maximum:.10g}"


class Place(click.types.StringParamType):
    """`HOST` or `HOST:PORT`."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the text. Raises click.BadParameter."""
        text: str = super().convert(value, param, ctx)
        host, colon, port = text.rpartition(":")
        good = port.isascii() and port.isdecimal() and 0 < int(port) < _PORTS
        if not (host and good if colon else text):
            self.fail(f"'{text}' is not HOST or HOST:PORT.", param, ctx)
        return text


class WholeRange(click.IntRange):
    """A range of whole numbers."""

    def _describe_range(self) -> str:
        return _in_words(self.min, self.max, is_open=self.min_open)


class FiniteRange(click.FloatRange):
    """A range of numbers that excludes `nan` and `inf`."""

    def _describe_range(self) -> str:
        return _in_words(self.min, self.max, is_open=self.min_open)

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Convert the option's text. Raises click.BadParameter."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a number of that range.", param, ctx)
        return number
