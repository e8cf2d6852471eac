"""Values of objects and calls with keyword arguments, as Python text in black's form."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rtgen.compiler.backends.kit.python_text import tuple_of
from rtgen.compiler.backends.kit.quoting.python import (
    Python,
    number_literal,
    string_literal,
)


def literal(value: bool | int | float | str | bytes | None) -> Python:
    """Return a value of an object."""
    match value:
        case str():
            return string_literal(value)
        case bytes():
            return octets_literal(value)
        case float() if not math.isfinite(value):
            return Python(f'float("{value!r}")')
        case float():
            return number_literal(value)
    return Python(repr(value))


def octets_literal(value: bytes) -> Python:
    """Return octets in hexadecimal digits."""
    return Python('b"' + "".join(f"\\x{octet:02x}" for octet in value) + '"')


def number(index: int, subindex: int) -> Python:
    """Return index and sub-index as two arguments."""
    return Python(f"0x{index:04X}, {subindex}")


def named(index: int, subindex: int) -> str:
    """Return index and sub-index as text: `6401:1`."""
    return f"{index:04X}:{subindex:X}" if subindex else f"{index:04X}"


def call(callee: str, *arguments: str, **named_ones: str) -> Python:
    """Return a call on one line; empty keyword arguments are omitted."""
    keywords = (f"{key}={value}" for key, value in named_ones.items() if value)
    return Python(f"{callee}({', '.join((*arguments, *keywords))})")


def items(texts: Sequence[str]) -> Python:
    """Return a tuple on one line."""
    return Python(tuple_of(texts).flat)
