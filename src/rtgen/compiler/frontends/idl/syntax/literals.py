"""Values of literals (CORBA 2.6, 3.2.5)."""

from __future__ import annotations

import re
from decimal import Decimal

import msgspec

_DECIMAL = re.compile(r"[1-9]\d*|0+")
_OCTAL = re.compile(r"0[0-7]+")
_HEXADECIMAL = re.compile(r"0[xX][0-9a-fA-F]+")
_FLOAT = re.compile(r"(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+")
_PLAIN = re.compile(
    rf"{_DECIMAL.pattern}|{_HEXADECIMAL.pattern}|{_OCTAL.pattern}|{_FLOAT.pattern}"
)
_BINARY = re.compile(r"0[bB][01]+")
_GROUPED = re.compile(r"\d+(?:_\d+)+")
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
_MAX_INTEGER = 2**64 - 1


class LiteralError(Exception):
    """An invalid literal; `hint` suggests a valid one."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.hint = hint
        super().__init__(message)


class LiteralText(msgspec.Struct, frozen=True):
    """A character or string: its value, and invalid escapes in it."""

    value: str
    wide: bool
    unknown_escapes: tuple[str, ...] = ()
    broken: bool = False


def number(text: str) -> int | float | Decimal:
    """Return the value of a number; fixed-point numbers are Decimals. Raises LiteralError."""
    if (
        _DECIMAL.fullmatch(text)
        or _OCTAL.fullmatch(text)
        or _HEXADECIMAL.fullmatch(text)
    ):
        if len(text) > 30:
            message = "the number is larger than 64 bits"
            raise LiteralError(message, f"the largest number is {_MAX_INTEGER}")
        base = 16 if text[1:2] in ("x", "X") else 8 if text[0] == "0" else 10
        value = int(text, base)
        if value > _MAX_INTEGER:
            message = f"{text} is larger than 64 bits"
            raise LiteralError(message, f"the largest number is {_MAX_INTEGER}")
        return value
    if _FLOAT.fullmatch(text):
        if len(text) > 1000:
            raise LiteralError("the number has more than 1000 characters")
        return float(text)
    fixed = _FIXED.fullmatch(text)
    if fixed is not None:
        return _fixed(fixed[1])
    if text.isdigit():
        message = f"{text} begins with 0, so it is octal, but holds an 8 or a 9"
        raise LiteralError(message, f"write {text.lstrip('0') or '0'}")
    excerpt = text if len(text) < 40 else text[:37] + "..."
    plain = (
        text.rstrip("fFlLuU") if text[1:2] not in ("x", "X") else text.rstrip("lLuU")
    )
    if plain != text and _PLAIN.fullmatch(plain):
        suffix = text[len(plain) :]
        raise LiteralError(f"{excerpt} ends with '{suffix}'", f"write {plain}")
    if _BINARY.fullmatch(text) and len(text) < 70:
        value = int(text, 2)
        raise LiteralError(f"{excerpt} is not a number", f"write {value} or {value:#x}")
    if _GROUPED.fullmatch(text):
        raise LiteralError(
            f"{excerpt} is not a number", f"write {text.replace('_', '')}"
        )
    raise LiteralError(
        f"{excerpt} is not a number",
        "write 10, 0x1f, 1.5 or 1.5e-3; fixed-point ones end with d",
    )


def _fixed(digits: str) -> Decimal:
    whole, _, fraction = digits.partition(".")
    whole, fraction = whole.lstrip("0"), fraction.rstrip("0")
    if len(whole) + len(fraction) > 31:
        raise LiteralError("a fixed-point number has at most 31 digits", "round it")
    return Decimal(f"{whole or '0'}.{fraction}" if fraction else whole or "0")


def text(parts: tuple[str, ...], character: bool) -> LiteralText:
    """Return the value of a character, or of adjacent strings. Raises LiteralError.

    The parts include their quotes.
    """
    wide = parts[0][0] == "L"
    unknown: list[str] = []
    values = []
    for part in parts:
        if (part[0] == "L") != wide:
            message = "wide and narrow strings cannot be joined"
            raise LiteralError(message, "put L before each part, or before none")
        values.append(_unescaped(part[1 + wide : -1], wide, unknown))
    value = "".join(values)
    if character and len(value) != 1:
        what = "no character" if not value else f"{len(value)} characters"
        message = f"a character literal holds one character, not {what}"
        raise LiteralError(message, 'strings are written as "..."')
    if not character and "\0" in value:
        message = "a string cannot hold a NUL character"
        raise LiteralError(message, "use sequence<octet> for bytes")
    if character and not wide and ord(value) > 255:
        raise LiteralError(
            f"'{value}' is not a char", f"a wide character is written L'{value}'"
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
                message = f"\\{octal} is larger than a character"
                raise LiteralError(message, "the largest is \\377")
            return chr(code)
        if short is not None:
            return chr(int(short, 16))
        if long is not None:
            if not wide:
                message = "\\u is allowed only in wide literals"
                raise LiteralError(message, "put L before the literal")
            return chr(int(long, 16))
        if other is None or other in "xu":
            message = f"\\{other or ''} needs digits after it"
            raise LiteralError(message, "write \\\\ for a backslash")
        if other not in _SIMPLE:
            unknown.append(other)
        return _SIMPLE.get(other, other)

    return _ESCAPE.sub(value, inner)
