"""Constants, defaults and comments in interface files, with the escapes of rosidl."""

from __future__ import annotations

import math
import re
from typing import Final

from rtgen.compiler.model import InitialValue
from rtgen.facts.primitives import Primitive
from rtgen.ros2.rosidl.values import Value, parsed, parsed_list

_MARKS: Final = re.compile(r"[\"#=\\\x00-\x1f\x7f-\x9f\u2028\u2029]")
"""Characters that are not written as they are: in rosidl they end a text, or the line."""
_ENDS: Final = re.compile(r"[#=\x00-\x1f\x7f-\x9f\u2028\u2029]")
_BACKSLASH: Final = "\\" * 8
"""A backslash, which rosidl halves three times."""


def literal(
    value: InitialValue, kind: Primitive | None, bound: int | None = None
) -> str:
    """Return the text of a constant or default; `kind` None is a string of at most `bound`.

    Raises ValueError for a value that interface files cannot have.
    """
    plain = _plain(value, kind)
    if isinstance(plain, tuple):
        text = f"[{', '.join(_element(each) for each in plain)}]"
        read: Value = parsed_list(text, kind, bound)
    else:
        text = f'"{_escaped(plain)}"' if isinstance(plain, str) else _number(plain)
        read = parsed(text, kind, bound)
    if read != plain:
        raise ValueError(f"the value {value!r}")
    return text


def comment(line: str) -> str:
    """Return a line for a comment, in which rosidl replaces escapes, too."""
    line = re.sub(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]", " ", line)
    for text in (line, line.replace("\\", "\\" * 4)):
        try:
            parsed(f"({text}", None)
        except ValueError:
            continue
        return text
    return line.replace("\\", "/")


def _plain(value: InitialValue, kind: Primitive | None) -> Value:
    """Return a value as readers of interface files have it: of a character its code."""
    if isinstance(value, tuple):
        return tuple(_plain(each, kind) for each in value)  # type: ignore[misc]
    if kind is None:
        return str(value)
    if isinstance(value, str) and len(value) == 1:
        return ord(value)
    if not isinstance(value, bool | int | float) or not math.isfinite(value):
        raise ValueError(f"the value {value!r}")
    return bool(value) if kind is Primitive.BOOLEAN else value


def _number(value: bool | int | float) -> str:
    return repr(value).lower()


def _element(value: Value) -> str:
    """Return an item of an array, where texts have no escapes but that of the quote."""
    if not isinstance(value, str):
        assert not isinstance(value, tuple)
        return _number(value)
    if _ENDS.search(value):
        raise ValueError(f"the item {value!r}")
    text = value.replace('"', '\\"')
    return f'"{text}"'


def _escaped(text: str) -> str:
    return _MARKS.sub(lambda match: _escape(match[0]), text)


def _escape(mark: str) -> str:
    if mark == "\\":
        return _BACKSLASH
    if mark in '"#=':
        return f"\\x{ord(mark):02x}"
    if ord(mark) < 0x100:
        return f"\\\\x{ord(mark):02x}"
    return "".join(f"\\x{octet:02x}" for octet in mark.encode())
