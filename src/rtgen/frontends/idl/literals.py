"""Literals as written, and the values that they stand for (CORBA 2.6, 3.2.5)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal

_DECIMAL = re.compile(r"[1-9]\d*|0+")
_OCTAL = re.compile(r"0[0-7]+")
_HEXADECIMAL = re.compile(r"0[xX][0-9a-fA-F]+")
_FLOAT = re.compile(r"(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+")
_FIXED = re.compile(r"(\d+\.?\d*|\.\d+)[dD]")
_ESCAPE = re.compile(
    r"\\(?:([0-7]{1,3})|x([0-9a-fA-F]{1,2})|u([0-9a-fA-F]{1,4})|(.)|$)", re.DOTALL
)
_SIMPLE = {
    "n": "\n",
    "t": "\t",
    "v": "\v",
    "b": "\b",
    "r": "\r",
    "f": "\f",
    "a": "\a",
    "\\": "\\",
    "?": "?",
    "'": "'",
    '"': '"',
}
_LARGEST = 2**64 - 1


class LiteralError(Exception):
    """A literal that stands for nothing."""


@dataclass(frozen=True, slots=True)
class LiteralText:
    """A character or string: its value, and the escapes in it that are none."""

    value: str
    wide: bool
    unknown_escapes: tuple[str, ...] = ()
    broken: bool = False


def number(text: str) -> int | float | Decimal:
    """The value of a number; fixed-point ones are Decimals. Raises LiteralError."""
    if (
        _DECIMAL.fullmatch(text)
        or _OCTAL.fullmatch(text)
        or _HEXADECIMAL.fullmatch(text)
    ):
        if len(text) > 30:
            raise LiteralError("the number is larger than 64 bits")
        base = 16 if text[1:2] in ("x", "X") else 8 if text[0] == "0" else 10
        value = int(text, base)
        if value > _LARGEST:
            raise LiteralError(f"{text} is larger than 64 bits")
        return value
    if _FLOAT.fullmatch(text):
        if len(text) > 1000:
            raise LiteralError("the number has more than 1000 characters")
        return float(text)
    fixed = _FIXED.fullmatch(text)
    if fixed is not None:
        return _fixed(fixed[1])
    if text.isdigit():
        raise LiteralError(
            f"{text} begins with 0, so it is octal, but holds an 8 or a 9"
        )
    if text[-1:] in "fFlLuU" and _FLOAT.fullmatch(text[:-1]):
        raise LiteralError(f"{text} has a suffix; write {text[:-1]}")
    raise LiteralError(f"{text if len(text) < 40 else text[:37] + '...'} is no number")


def _fixed(digits: str) -> Decimal:
    whole, _, fraction = digits.partition(".")
    whole, fraction = whole.lstrip("0"), fraction.rstrip("0")
    if len(whole) + len(fraction) > 31:
        raise LiteralError("a fixed-point number has at most 31 digits")
    return Decimal(f"{whole or '0'}.{fraction}" if fraction else whole or "0")


def text(parts: tuple[str, ...], character: bool) -> LiteralText:
    """The value of a character, or of adjacent strings, each with quotes. Raises LiteralError."""
    wide = parts[0][0] == "L"
    unknown: list[str] = []
    values = []
    for part in parts:
        if (part[0] == "L") != wide:
            raise LiteralError("wide and narrow strings cannot be joined")
        values.append(_unescaped(part[1 + wide : -1], wide, unknown))
    value = "".join(values)
    if character and len(value) != 1:
        what = "no character" if not value else f"{len(value)} characters"
        raise LiteralError(f"a character literal holds one character, not {what}")
    if not character and "\0" in value:
        raise LiteralError("a string cannot hold a NUL character")
    if character and not wide and ord(value) > 255:
        raise LiteralError(
            f"'{value}' is no char; a wide character is written L'{value}'"
        )
    broken = any("\n" in part for part in parts)
    return LiteralText(value, wide, tuple(unknown), broken)


def _unescaped(inner: str, wide: bool, unknown: list[str]) -> str:
    if "\\" not in inner:
        return inner

    def value(match: re.Match[str]) -> str:
        octal, short, long, other = match.groups()
        if octal is not None:
            code = int(octal, 8)
            if code > 255:
                raise LiteralError(f"\\{octal} is larger than a character")
            return chr(code)
        if short is not None:
            return chr(int(short, 16))
        if long is not None:
            if not wide:
                raise LiteralError("\\u stands in wide literals only")
            return chr(int(long, 16))
        if other is None or other in "xu":
            raise LiteralError(f"\\{other or ''} needs digits behind it")
        if other not in _SIMPLE:
            unknown.append(other)
        return _SIMPLE.get(other, other)

    return _ESCAPE.sub(value, inner)
