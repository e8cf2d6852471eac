"""Facts of declarations and their parts as JSON: for each class, its fields in order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from decimal import Decimal
from enum import Enum
from functools import cache
from operator import attrgetter
from types import NoneType
from typing import Any, TypeAlias

import msgspec

from rtgen.compiler.model import Annotation, Documented, EnumeratorName, ScopedName

Json: TypeAlias = dict[str, Any]

FIELDS: dict[type, str] = {}
"""The keys of a class: `key` or `key=attribute`; `::` follows a scoped name, `::*` several."""

_Field: TypeAlias = tuple[str, Callable[[Any], Any], Callable[[Any], Any]]


def facts(item: msgspec.Struct, **known: Any) -> Json:
    """Return the fields of an item as JSON, with `known` instead of its own values or added."""
    own, description = _fields(type(item))
    if not known:
        return {key: convert(get(item)) for key, get, convert in own + description}
    found = {
        key: known[key] if key in known else convert(get(item))
        for key, get, convert in own
    }
    return found | known | {key: to(get(item)) for key, get, to in description}


@cache
def _fields(kind: type) -> tuple[tuple[_Field, ...], tuple[_Field, ...]]:
    """Return the fields of a class, and those of its description."""
    own = []
    for word in FIELDS[kind].split():
        name, mark, several = word.partition("::")
        key, _, attribute = name.partition("=")
        convert = _scoped_names if several else scoped if mark else plain
        own.append((key, attrgetter(attribute or key), convert))
    return tuple(own), _DESCRIPTION if issubclass(kind, Documented) else ()


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
    kind: Any = type(value)
    return _converter(kind)(value)


@cache
def _converter(kind: type) -> Callable[[Any], Any]:
    """Return the function that converts values of a class."""
    if kind in FIELDS:
        return facts
    if issubclass(kind, Enum):
        return attrgetter("_value_")  # `value` is a slow property in Python 3.11
    return next((to for base, to in _CONVERTERS.items() if issubclass(kind, base)), str)


def _annotations(annotations: Iterable[Annotation]) -> list[Json]:
    return [
        {"name": a.name, "arguments": plain(dict(a.arguments))} for a in annotations
    ]


def scoped(name: ScopedName | None) -> str | None:
    """Return a scoped name as text; None for no name."""
    return "::".join(name) if name else None


def _itself(value: Any) -> Any:
    return value


_DESCRIPTION: tuple[_Field, ...] = (
    ("doc", attrgetter("doc"), _itself),
    ("annotations", attrgetter("annotations"), _annotations),
)
_CONVERTERS: dict[type, Callable[[Any], Any]] = {
    NoneType: _itself,
    int: _itself,
    str: _itself,
    float: lambda value: value if math.isfinite(value) else str(value),
    bytes: bytes.hex,
    tuple: lambda values: [*map(plain, values)],
    list: lambda values: [*map(plain, values)],
    dict: lambda items: {key: plain(each) for key, each in items.items()},
    EnumeratorName: lambda enumerator: scoped(enumerator.name),
    Decimal: lambda value: format(value, "f"),
}
