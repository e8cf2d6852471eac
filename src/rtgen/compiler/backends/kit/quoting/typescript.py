"""Literals and comments of TypeScript (ECMA-262, 12)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from decimal import Decimal

from rtgen.compiler.backends.kit.quoting.code import Code, UnquotableError
from rtgen.compiler.model import ConstantValue

_CONTROL = re.compile(r"[^\t\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\U0010ffff]")
_NAME = re.compile(r"[A-Za-z0-9_$./]*")
_IDENTIFIER = re.compile(r"[A-Za-z0-9_$]+")


class TypeScript(Code):
    """TypeScript source text."""

    __slots__ = ()


def quote(value: object) -> str:
    """Filter of TypeScript templates: accepts code, names and paths.

    Raises UnquotableError for other texts: they need `literal` or `comment`.
    """
    if isinstance(value, TypeScript):
        return value
    text = str(value)
    if isinstance(value, Code) or not _NAME.fullmatch(text):
        raise UnquotableError(text, "TypeScript")
    return TypeScript(text)


def string(text: str) -> TypeScript:
    """Return a string literal, in ASCII."""
    return TypeScript(json.dumps(text))


def property_name(name: str) -> TypeScript:
    """Return the name of a property, a string literal if it is no identifier."""
    return TypeScript(name) if _IDENTIFIER.fullmatch(name) else string(name)


def constant(value: ConstantValue, *, is_64_bit: bool) -> str:
    """Return the literal of a number, text or boolean; 64-bit numbers are bigints."""
    match value:
        case bool():
            return "true" if value else "false"
        case int():
            return f"{value}n" if is_64_bit else str(value)
        case float():
            named = {"inf": "Infinity", "-inf": "-Infinity", "nan": "NaN"}
            return named.get(str(value), repr(value))
        case Decimal():
            return string(str(value))
    return string(str(value))


def line_comment(lines: Iterable[str]) -> TypeScript:
    """Return lines as comments."""
    return TypeScript("\n".join(f"// {line}".rstrip() for line in lines))


def comment(text: str, indent: int = 0) -> TypeScript:
    """Return the text as a doc comment with a final newline; empty for an empty text."""
    clean = _CONTROL.sub("\ufffd", text).replace("*/", "* /").strip()
    if not clean:
        return TypeScript("")
    lines, margin = clean.splitlines(), " " * indent
    if len(lines) == 1:
        return TypeScript(f"{margin}/** {lines[0]} */\n")
    body = "".join(f"{margin} * {line}".rstrip() + "\n" for line in lines)
    return TypeScript(f"{margin}/**\n{body}{margin} */\n")
