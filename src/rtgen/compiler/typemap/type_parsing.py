"""Parses types in the canonical spelling of `str` (without `fixed` and maps)."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rtgen.compiler.model import (
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)

_STRING = re.compile(r"(w?)string(?:<(\d{1,9})>)?")
_SEQUENCE = re.compile(r"sequence<(.+?)(?:,(\d{1,9}))?>")
_NAME = re.compile(r"[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*", re.ASCII)
_PRIMITIVES = frozenset(kind.value for kind in Primitive)
_MAX_LENGTH = 1000


def parsed(text: str) -> Type:
    """Parse a type. Raises ValueError."""
    if len(text) > _MAX_LENGTH:
        raise ValueError("a type is too long")
    if text in _PRIMITIVES:
        return PrimitiveType(Primitive(text))
    if (match := _STRING.fullmatch(text)) is not None:
        return StringType(bool(match[1]), _bound(match[2]))
    if (match := _SEQUENCE.fullmatch(text)) is not None:
        return SequenceType(parsed(match[1]), _bound(match[2]))
    if _NAME.fullmatch(text):
        return NamedType(tuple(text.split("::")))
    raise ValueError(f"{text[:40]!r} is not a type")


def _bound(text: str | None) -> int | None:
    return None if text is None else int(text)


def names_in(type_: Type) -> Iterator[NamedType]:
    """Yield the declared types in a type."""
    match type_:
        case NamedType():
            yield type_
        case SequenceType(element):
            yield from names_in(element)
