"""IDL and Python names derived from those in device descriptions."""

from __future__ import annotations

import keyword
import re
from collections import Counter
from collections.abc import Iterable
from unicodedata import combining, normalize

from rtgen.compiler.model.canopen import Variable
from rtgen.compiler.typemap import idl_keywords

TABLES = ("DESCRIPTION", "CONFIGURATION", "REMAPPED")
"""The names of a device's tables in its Python package, besides the class of its objects."""

_PARTS = re.compile(r"[A-Za-z0-9]+")
_OTHER = re.compile(r"[^A-Za-z0-9]+")


def module_name(stem: str) -> str:
    """Return the IDL module of a device: Pascal case of the file's stem."""
    parts = _PARTS.findall(_ascii(stem))
    name = "".join(part[0].upper() + part[1:] for part in parts)
    return f"Device{name}" if not name or name[0].isdigit() else name


def table_class(module: str) -> str:
    """Return the class of a device's objects in Python."""
    return f"{module}Objects"


def _ascii(text: str) -> str:
    """Remove diacritics; characters without an ASCII base are kept."""
    return "".join(c for c in normalize("NFKD", text) if not combining(c))


def identifier(name: str) -> str:
    """Return the name as an identifier: ASCII, runs of other characters replaced by `_`."""
    text = _OTHER.sub("_", _ascii(name))
    return text if text[:1].isalpha() else f"o_{text.lstrip('_')}"


def field_names(variables: Iterable[Variable]) -> dict[tuple[int, int], str]:
    """Return the identifiers of a device's variables by index and sub-index.

    The number is appended to names that differ in case only, or that are keywords of IDL or Python.
    """
    numbers = {v.number: identifier(v.name) for v in variables}
    counts = Counter(name.lower() for name in numbers.values())
    names = {
        number: (
            name
            if counts[name.lower()] == 1 and not _is_keyword(name)
            else numbered(name, number)
        )
        for number, name in numbers.items()
    }
    counts = Counter(name.lower() for name in names.values())
    return {
        number: (
            name
            if counts[name.lower()] == 1 or name != numbers[number]
            else numbered(name, number)
        )
        for number, name in names.items()
    }


def numbered(name: str, number: tuple[int, int]) -> str:
    """Return the name with the object's number appended: `Input_6401_01`."""
    index, subindex = number
    return f"{name}_{index:04X}_{subindex:02X}"


def _is_keyword(name: str) -> bool:
    return idl_keywords.escaped(name) != name or keyword.iskeyword(name)
