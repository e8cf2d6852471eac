"""Calls of operations as people write them: `INSTANCE.PORT.OPERATION(arguments)`."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, TypeVar

T = TypeVar("T")
Value: TypeAlias = Any
"""A value as JSON; an enumerator is a text."""

_MAX_LENGTH: Final = 1 << 16
_MAX_DEPTH: Final = 32
_MAX_DIGITS: Final = 400
_TOKEN: Final = r"""\s*(?:
    (?P<number>[-+]?(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\w.]))
  | (?P<word>[-+]?[^\W\d]\w*(?:::\w+)*)
  | (?P<text>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')
  | (?P<sign>[\[\]{}(),=:])
)"""
_TARGET: Final = r"\s*([^.()\s]+)\.([^()\s]+)\.([^.():\s]+)\s*(\(|$)"
_WORDS: Final = {
    "true": True,
    "false": False,
    "null": None,
    "TRUE": True,
    "FALSE": False,
}
_ESCAPES: Final = {"n": "\n", "t": "\t", "r": "\r"}


class CallTextError(Exception):
    """A text that is no call; the message says where."""


@dataclass(frozen=True, slots=True)
class CallText:
    """A call: `port` may have the name of an interface in it, `text` is the call as written.

    Each of `arguments` is a value with the name of its parameter, empty for the next one.
    """

    text: str
    instance: str
    port: str
    operation: str
    arguments: Sequence[tuple[str, Value]] = ()


def parse(text: str) -> CallText:
    """Parse a call, whose parentheses may be missing. Raises CallTextError."""
    if len(text) > _MAX_LENGTH:
        raise CallTextError(f"a call of {len(text)} characters")
    match = re.match(_TARGET, text)
    if match is None:
        raise CallTextError(f"{text[:80]!r} is not INSTANCE.PORT.OPERATION(arguments)")
    instance, port, operation, opening = match.groups()
    arguments: Sequence[tuple[str, Value]] = ()
    if opening:
        tokens = _Tokens(text, match.end())
        arguments = tokens.listed(")", tokens.argument)
        if tokens.next() is not None:
            raise CallTextError(f"{text[:80]!r} goes on after its parentheses")
    return CallText(text.strip(), instance, port, operation, arguments)


def parse_value(text: str) -> Value:
    """Parse one value. Raises CallTextError."""
    if len(text) > _MAX_LENGTH:
        raise CallTextError(f"a value of {len(text)} characters")
    tokens = _Tokens(text, 0)
    value = tokens.value()
    if tokens.next() is not None:
        raise CallTextError(f"{text[:80]!r} is not one value")
    return value


class _Tokens:
    """The tokens of a text, with the values that they form."""

    def __init__(self, text: str, start: int) -> None:
        self._pattern = re.compile(_TOKEN, re.VERBOSE)
        self._text = text.rstrip()
        self._place = start
        self._depth = 0

    def next(self) -> re.Match[str] | None:
        """Return the next token; None at the end."""
        if self._place >= len(self._text):
            return None
        match = self._pattern.match(self._text, self._place)
        if match is None:
            raise self._wrong('a value, such as 1.5, ON, "text", [1, 2], {x = 1}')
        self._place = match.end()
        return match

    def _next_is(self, signs: str) -> str:
        """Consume the next token if it is one of some signs, and return it; else return ""."""
        before = self._place
        token = self.next()
        if token is not None and token["sign"] and token["sign"] in signs:
            return token["sign"]
        self._place = before
        return ""

    def _wrong(self, expected: str) -> CallTextError:
        rest = self._text[self._place :].strip()[:20]
        at = f"at {rest!r}" if rest else "at the end"
        return CallTextError(f"{self._text[:80]!r}: {expected} is expected {at}")

    def listed(self, end: str, item: Callable[[], T]) -> list[T]:
        """Return the items up to a sign, separated by commas."""
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise CallTextError(f"more than {_MAX_DEPTH} levels of values")
        items: list[T] = []
        while not self._next_is(end):
            if items and not self._next_is(","):
                raise self._wrong(f"',' or {end!r}")
            items.append(item())
        self._depth -= 1
        return items

    def argument(self) -> tuple[str, Value]:
        """Return an argument with the name of its parameter, empty without one."""
        before = self._place
        token = self.next()
        if token is not None and token["word"] and self._next_is("="):
            return token["word"], self.value()
        self._place = before
        return "", self.value()

    def _member(self) -> tuple[str, Value]:
        token = self.next()
        name = None if token is None else token["word"] or token["text"]
        if not name or not self._next_is("=:"):
            raise self._wrong("a member, such as x = 1")
        return (_unquoted(name) if token and token["text"] else name), self.value()

    def value(self) -> Value:
        """Return the next value."""
        before = self._place
        token = self.next()
        if token is None:
            raise self._wrong("a value")
        match token.lastgroup, token[token.lastgroup or 0]:
            case "number", text:
                return _number(text)
            case "word", ("nan" | "inf" | "-inf" | "+inf") as text:
                return text.removeprefix("+")
            case "word", text if text[0] not in "-+":
                return _WORDS.get(text, text.rpartition("::")[2])
            case "text", text:
                return _unquoted(text)
            case "sign", "[":
                return self.listed("]", self.value)
            case "sign", "{":
                return dict(self.listed("}", self._member))
        self._place = before
        raise self._wrong("a value")


def _number(text: str) -> int | float:
    digits = text.lstrip("+-").lower()
    if len(digits) > _MAX_DIGITS:
        raise CallTextError(f"a number of {len(digits)} digits")
    if digits.startswith("0x"):
        return int(text, 16)
    if digits.isdecimal():
        return int(text)
    return float(text)


def _unquoted(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), text[1:-1], flags=re.S)
