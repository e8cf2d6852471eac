"""Values of configuration parameters as text, as profiles, `.conf` files and tools write them."""

from __future__ import annotations

import re
from decimal import Decimal
from typing import Any, Final

TRUE: Final = ("true", "1", "yes", "on")
FALSE: Final = ("false", "0", "no", "off")
"""The words for truth values, in any case."""

_INTEGER = re.compile(r"[+-]?[0-9]{1,40}")
_NOT_IN_NUMBERS = re.compile(r"[^ -~]|_")


def boolean(text: str) -> bool:
    """The truth value of a text. Raises ValueError."""
    word = text.strip().lower()
    if word not in TRUE + FALSE:
        raise ValueError("it must be true or false")
    return word in TRUE


def integer(text: str) -> int:
    """The decimal integer of a text. Raises ValueError."""
    if not _INTEGER.fullmatch(text.strip()):
        raise ValueError("it must be a decimal integer")
    return int(text)


def number(text: str) -> float:
    """The number of a text; `nan` and `inf` are numbers, too. Raises ValueError."""
    try:
        return float("" if _NOT_IN_NUMBERS.search(text) else text)
    except ValueError:
        raise ValueError("it must be a number") from None


def items(text: str) -> list[str]:
    """The items of a sequence: between commas, trimmed; none in a blank text."""
    return [item.strip() for item in text.split(",")] if text.strip() else []


def text_of(value: Any) -> str:
    """The text of a value: a truth value, number, text, octets, or a list of these.

    Raises ValueError for others, and for lists whose items a text cannot hold.
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
