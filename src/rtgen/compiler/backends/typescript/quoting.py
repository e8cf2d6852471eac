"""Literals and comments of TypeScript (ECMA-262, 12)."""

from __future__ import annotations

import json
import re
from decimal import Decimal

from rtgen.compiler.model import ConstantValue

_CONTROL = re.compile(r"[^\t\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\U0010ffff]")


def string(text: str) -> str:
    """Return a string literal, in ASCII."""
    return json.dumps(text)


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


def comment(text: str, indent: str = "") -> list[str]:
    """Return the lines of a doc comment; none for an empty text."""
    clean = _CONTROL.sub("\ufffd", text).replace("*/", "* /").strip()
    if not clean:
        return []
    lines = clean.splitlines()
    if len(lines) == 1:
        return [f"{indent}/** {lines[0]} */"]
    body = [f"{indent} * {line}".rstrip() for line in lines]
    return [f"{indent}/**", *body, f"{indent} */"]
