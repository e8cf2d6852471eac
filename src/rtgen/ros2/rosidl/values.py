"""Parses constants and defaults in ROS 2 interface files, as rosidl reads them.

rosidl_adapter converts an interface file to IDL, which rosidl_parser reads (Jazzy and Kilted): a
text passes through both, each with its own escapes.
"""

from __future__ import annotations

import math
import re
import sys
import unicodedata
from typing import Final, TypeAlias

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES, Primitive

Scalar: TypeAlias = bool | int | float | str
Value: TypeAlias = Scalar | tuple[Scalar, ...]

_BOOLEANS: Final = {"true": True, "1": True, "false": False, "0": False}
QUOTES: Final = "\"'"
_ESCAPES: Final = {
    **{character: character for character in "\\'\""},
    **dict(zip("abfnrtv", "\a\b\f\n\r\t\v", strict=True)),
}
_ESCAPE: Final = re.compile(
    r"\\(?:(?P<one>[\\'\"abfnrtv])|(?P<octal>[0-7]{1,3})|x(?P<x>[0-9A-Fa-f]{2})"
    r"|u(?P<u>[0-9A-Fa-f]{4})|U(?P<U>[0-9A-Fa-f]{8})|N\{(?P<name>[^}]*)\}"
    r"|(?P<wrong>[xuUN]|$))"
)
"""Escapes of Python, which rosidl_adapter replaces; other characters keep their backslash."""
_ESCAPE_OF_IDL: Final = re.compile(
    r"\\(?:(?P<one>[\\'\"abfnrtv])|(?P<octal>[0-7]{1,3})|x(?P<x>[0-9A-Fa-f]{1,2}))"
)
"""Escapes of IDL (OMG IDL 4.2, table 7-9), of which rosidl_parser knows these."""
_ELEMENT: Final = re.compile(
    r"(?P<quote>['\"])(?P<text>(?:(?!(?P=quote))[^\\]|\\.)*)(?P=quote)(?:, |$)",
    re.DOTALL,
)
"""A string in the text of a tuple."""


def parsed(text: str, kind: Primitive | None, bound: int | None = None) -> Scalar:
    """Parse a value; `kind` None is a string of at most `bound` characters.

    Raises ValueError with the reason.
    """
    value = _scalar(text, kind, bound)
    return _through_idl(value) if isinstance(value, str) else value


def parsed_list(
    text: str, kind: Primitive | None, bound: int | None = None
) -> tuple[Scalar, ...]:
    """Parse the default of an array or sequence. Raises ValueError with the reason."""
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError("is not written as [a, b]")
    inner = text[1:-1]
    split = _strings if kind is None else _numbers
    values = [_scalar(element.strip(), kind, bound) for element in split(inner)]
    if any(isinstance(each, float) and not math.isfinite(each) for each in values):
        raise ValueError("has a number that is not finite")
    return _strings_through_idl(values) if kind is None else tuple(values)


def has_open_quote(text: str) -> bool:
    """Return whether a string begins with a quote that none closes."""
    return text[:1] in ("'", '"') and (len(text) == 1 or text[-1] != text[0])


def _numbers(text: str) -> list[str]:
    return text.split(",") if text else []


def _scalar(text: str, kind: Primitive | None, bound: int | None) -> Scalar:
    if kind is None:
        return _string(text, bound)
    if kind is Primitive.BOOLEAN:
        value = _BOOLEANS.get(text.lower())
        if value is None:
            raise ValueError("is neither true nor false")
        return value
    if kind in FLOAT_LIMITS:
        return _real(text, kind)
    number = _integer(text)
    lowest, highest = INTEGER_RANGES[kind]
    if not lowest <= number <= highest:
        raise ValueError(f"is not in {lowest} to {highest}")
    return number


def _integer(text: str) -> int:
    """Return a decimal number, which may begin with zeros, else one with the prefix of its base."""
    for base in (10, 0):
        try:
            return int(text, base)
        except ValueError:
            continue
    raise ValueError("is not an integer")


def _real(text: str, kind: Primitive) -> float:
    try:
        number = float(text)
    except ValueError:
        raise ValueError("is not a number") from None
    if math.isfinite(number) and abs(number) > FLOAT_LIMITS[kind]:
        raise ValueError("is too large for float32")
    return number


def _string(text: str, bound: int | None) -> str:
    """Return a string without its quotes, before its escapes are replaced."""
    for quote in QUOTES:
        if text.startswith(quote) and text.endswith(quote):
            text = text[1:-1]
            if re.search(rf"(?<!\\){quote}", text):
                raise ValueError(f"has a quote that is not written \\{quote}")
            text = text.replace(f"\\{quote}", quote)
            break
    if bound is not None and len(text) > bound:
        raise ValueError(f"is longer than {bound} characters")
    return text


def _strings(text: str) -> list[str]:
    """Split the elements of an array of strings, in which commas may be quoted."""
    strings = []
    at = 0
    while at < len(text):
        at = _after_spaces(text, at)
        if text[at : at + 1] in ("", ","):
            raise ValueError("has an element without a value")
        if (quote := text[at]) in QUOTES:
            end = _closing_quote(text, at, quote)
            strings.append(text[at + 1 : end].replace(f"\\{quote}", quote))
            at = end + 1
        else:
            end = text.find(",", at)
            end = len(text) if end < 0 else end
            strings.append(text[at:end])
            at = end
        at = _after_spaces(text, at)
        if text[at : at + 1] == ",":
            at += 1
    return strings


def _after_spaces(text: str, at: int) -> int:
    while text[at : at + 1] == " ":
        at += 1
    return at


def _closing_quote(text: str, first: int, quote: str) -> int:
    """Return where rosidl sees the end of an element whose first character is a quote.

    A quote directly behind an escaped one does not count, and behind two escaped ones the place is
    that behind the last but one.
    """
    start = end = first
    while (place := text.find(quote, start + 1)) >= 0:
        if text[place - 1] != "\\":
            return end + place - start
        end = first + place + 1 - start
        start = place + 1
    raise ValueError("has a quote that is not closed")


def _through_idl(text: str) -> str:
    """Return a string with its escapes replaced, first by rosidl_adapter."""
    # The adapter replaces escapes in the octets of UTF-8.
    octets = _ESCAPE.sub(_character, text.encode().decode("latin-1"))
    return _of_literal(octets.replace('"', '\\"'))


def _strings_through_idl(values: list[Scalar]) -> tuple[Scalar, ...]:
    """Return the strings of an array, which pass through IDL as the text of a tuple in Python."""
    text = repr(tuple(values)).replace("\\", "\\\\").replace('"', '\\"')
    return of_tuple(_of_literal(text), None)


def of_tuple(text: str, kind: Primitive | None) -> tuple[Scalar, ...]:
    """Return the values of an array that is written as a tuple in Python. Raises ValueError."""
    text = text.removeprefix("(").removesuffix(")").removesuffix(",")
    if kind is not None:
        return tuple(_scalar(each.strip(), kind, None) for each in _numbers(text))
    scalars = []
    at = 0
    while at < len(text):
        match = _ELEMENT.match(text, at)
        if match is None:
            raise ValueError("has an escape that rosidl cannot convert")
        scalars.append(_ESCAPE.sub(_character, match["text"]))
        at = match.end()
    return tuple(scalars)


def _of_literal(text: str) -> str:
    """Return the string that rosidl_parser reads from a literal with this text in its quotes.

    The file of the literal is written in ISO 8859-1, and read as UTF-8.
    """
    try:
        text = text.encode("latin-1").decode()
    except UnicodeError:
        raise ValueError("has characters that rosidl cannot convert") from None
    if "\n" in text or "\r" in text:
        raise ValueError("has a line break, which rosidl cannot convert")
    if not _is_one_literal(text):
        raise ValueError("has a backslash before a quote or its end")
    return unescaped(text)


def unescaped(text: str) -> str:
    """Return the string that rosidl_parser reads from the text of a literal. Raises ValueError."""
    text = _ESCAPE_OF_IDL.sub(_character, text)
    return re.sub(r'\\(["\\])', r"\1", text)


def _is_one_literal(text: str) -> bool:
    """Return whether each quote, but not the end, has an odd number of backslashes before it."""
    end = 0
    backslashes = 0
    for match in re.finditer(r'\\+|"', text):
        if match.start() != end:
            backslashes = 0
        end = match.end()
        if match[0] != '"':
            backslashes = len(match[0])
        elif backslashes % 2 == 0:
            return False
        else:
            backslashes = 0
    return end != len(text) or backslashes % 2 == 0


def _character(match: re.Match[str]) -> str:
    """Return the character of an escape. Raises ValueError."""
    groups = match.groupdict()
    if (one := groups.get("one")) is not None:
        return _ESCAPES[one]
    if (octal := groups.get("octal")) is not None:
        return chr(int(octal, 8))
    if (name := groups.get("name")) is not None:
        try:
            return unicodedata.lookup(name)
        except KeyError:
            raise ValueError(f"has no character \\N{{{name}}}") from None
    digits = next((groups[key] for key in "xuU" if groups.get(key)), "")
    # rosidl_parser takes one digit for an escape, and then refuses it.
    if not digits or len(digits) == 1 or int(digits, 16) > sys.maxunicode:
        raise ValueError(f"has the incomplete escape {match[0]}")
    return chr(int(digits, 16))
