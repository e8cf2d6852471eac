"""Parses TOML and converts its errors to spans."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.kit.limits import MAX_LEVELS

_PLACE = re.compile(r"\s*\(at line (\d+), column (\d+)\)$")
_INVALID = "Invalid value"
_WORD = re.compile(r"[^\W\d][^\s,\]}#\"']*|(?<==)[ \t]*[./~][^\s,\]}#\"']*")
_TRUTH = {"True": "true", "yes": "true", "on": "true", "False": "false", "no": "false"}
_TRUTH |= {"off": "false", "TRUE": "true", "FALSE": "false"}
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+"""
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:{_PART}){{{MAX_LEVELS}}}")


class TomlError(Exception):
    """The text is not valid TOML; `span` is the place of the error, `hint` how to correct it."""

    def __init__(self, message: str, span: Span, hint: str | None = None) -> None:
        super().__init__(message)
        self.span = span
        self.hint = hint


def parse(text: str, file: str) -> dict[str, Any]:
    """Return the content of a TOML text; `file` is the name in spans. Raises TomlError."""

    def problem(message: str, line: int, column: int) -> TomlError:
        word, hint = _bare_word(text, line, column)
        if word and message == _INVALID:
            message = f"{word} is no value"
            end = column + len(word)
            return TomlError(message, Span(file, line, column, line, end), hint)
        return TomlError(message, Span(file, line, column, line, column + 1))

    # The library's time is quadratic in the length of a dotted key.
    if (deep := _DEEP_KEY.search(text)) is not None:
        before = text[: deep.start()].split("\n")
        message = f"a key has more than {MAX_LEVELS} parts"
        raise problem(message, len(before), len(before[-1]) + 1)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise problem("nested too deeply", 1, 1) from None
    except ValueError as error:  # or too many digits
        message = str(error)
        if (place := _PLACE.search(message)) is not None:
            line, column = int(place[1]), int(place[2])
        elif isinstance(error, tomllib.TOMLDecodeError):
            lines = text.split("\n")
            line, column = len(lines), len(lines[-1]) + 1
        else:
            message, line, column = "a number is too long", 1, 1
        message = _PLACE.sub("", message).removesuffix(" (at end of document)")
        raise problem(message.strip(), line, column) from None


def _bare_word(text: str, line: int, column: int) -> tuple[str, str | None]:
    """Return the word without quotes at a place, and a hint; an empty text if there is none."""
    lines = text.split("\n")
    match = _WORD.match(lines[line - 1], column - 1) if line <= len(lines) else None
    if match is None:
        return "", None
    word = match[0]
    return word, f"write {_TRUTH.get(word, chr(34) + word + chr(34))}"
