"""Text form of configuration parameters in profiles, `.conf` files and tools."""

from __future__ import annotations

import re
from decimal import Decimal
from enum import Enum
from typing import Any, Final

TRUE: Final = ("true", "1", "yes", "on")
FALSE: Final = ("false", "0", "no", "off")
"""The words for true and false, in any case."""

_INTEGER = re.compile(r"[+-]?[0-9]{1,40}")
_NOT_IN_NUMBERS = re.compile(r"[^ -~]|_")


def boolean(text: str) -> bool:
    """Parse a boolean. Raises ValueError."""
    word = text.strip().lower()
    if word not in TRUE + FALSE:
        raise ValueError("it must be true or false")
    return word in TRUE


def integer(text: str) -> int:
    """Parse a decimal integer. Raises ValueError."""
    if not _INTEGER.fullmatch(text.strip()):
        raise ValueError("it must be a decimal integer")
    return int(text)


def number(text: str) -> float:
    """Parse a number; `nan` and `inf` are numbers, too. Raises ValueError."""
    try:
        return float("" if _NOT_IN_NUMBERS.search(text) else text)
    except ValueError:
        raise ValueError("it must be a number") from None


def items(text: str) -> list[str]:
    """Split a sequence at commas and trim its items; none in a blank text."""
    return [item.strip() for item in text.split(",")] if text.strip() else []


def default_text(value: Any) -> str:
    """Return the text of a parameter's default in profiles; booleans are 1 and 0 there, which
    every target accepts.
    """
    match value:
        case bool():
            return str(int(value))
        case Enum():
            return value.name
        case list() | bytes():
            return ",".join(map(default_text, value))
    return str(value)


def text_of(value: Any) -> str:
    """Return the text of a value: a boolean, number, text, octets, or a list of these.

    Raises ValueError for other values, and for lists whose items cannot be written as one text.
    """
    match value:
        case bool():
            return "true" if value else "false"
        case int() | float() | Decimal() | str():
            return str(value)
        case list() | bytes():
            texts = [text_of(item) for item in value]
            if items(",".join(texts)) != texts:
                raise ValueError("no item of a list may be empty or contain a comma")
            return ",".join(texts)
    raise ValueError(f"it cannot be {str(value)[:60]!r}")
