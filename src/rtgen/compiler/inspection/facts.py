"""Facts of declarations and their parts as JSON: for each class, its fields in order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from decimal import Decimal
from enum import Enum
from functools import cache
from operator import attrgetter
from typing import Any, TypeAlias

import msgspec

from rtgen.compiler.model import Documented, EnumeratorName, ScopedName

Json: TypeAlias = dict[str, Any]

FIELDS: dict[type, str] = {}
"""The keys of a class: `key` or `key=attribute`; `::` follows a scoped name, `::*` several."""

_PLAIN = frozenset((bool, int, str))
_Field: TypeAlias = tuple[str, Callable[[Any], Any], Callable[[Any], Any]]


def facts(item: msgspec.Struct, **known: Any) -> Json:
    """Return the fields of an item as JSON, with `known` instead of its own values or added."""
    found = {
        key: known[key] if key in known else convert(get(item))
        for key, get, convert in _keys(type(item))
    }
    found |= known
    return found | documented(item) if isinstance(item, Documented) else found


@cache
def _keys(kind: type) -> tuple[_Field, ...]:
    fields = []
    for word in FIELDS[kind].split():
        name, mark, several = word.partition("::")
        key, _, attribute = name.partition("=")
        convert = _scoped_names if several else scoped if mark else plain
        fields.append((key, attrgetter(attribute or key), convert))
    return tuple(fields)


def _scoped_names(names: Iterable[ScopedName]) -> list[str | None]:
    return [*map(scoped, names)]


def kind_of(declaration: object) -> str:
    """Return the word for the kind of a declaration of IDL or CDL."""
    if getattr(declaration, "eventtype", False):
        return "eventtype"
    name = type(declaration).__name__
    return name.removeprefix("Tecs").removesuffix("Decl").lower()


def plain(value: Any) -> Any:
    """Return a value as JSON.

    Octets are hexadecimal digits; NaN, infinities, types and expressions are texts.
    """
    if value is None or type(value) in _PLAIN:
        return value
    match value:
        case Enum():
            return value.value
        case float():
            return value if math.isfinite(value) else str(value)
        case bytes():
            return value.hex()
        case tuple() | list():
            return [*map(plain, value)]
        case dict():
            return {key: plain(each) for key, each in value.items()}
        case EnumeratorName():
            return scoped(value.name)
        case Decimal():
            return format(value, "f")
        case msgspec.Struct() if type(value) in FIELDS:
            return facts(value)
    return str(value)


def documented(item: Documented) -> Json:
    """Return the description and the annotations of an item."""
    annotations = [
        {"name": a.name, "arguments": plain(dict(a.arguments))}
        for a in item.annotations
    ]
    return {"doc": item.doc, "annotations": annotations}


def scoped(name: ScopedName | None) -> str | None:
    """Return a scoped name as text; None for no name."""
    return "::".join(name) if name else None
