"""Names in IDL: distinct regardless of case; typedefs for anonymous types."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import (
    ArrayType,
    Declaration,
    NamedType,
    ScopedName,
    SequenceType,
    Type,
    Typedef,
    default_id,
)
from rtgen.compiler.model.tecs import TecsDeclaration


class IdlNames:
    """The names of one scope of IDL, which must differ in more than case."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = {name.lower() for name in taken}

    def add(self, name: str) -> str:
        """Return a valid and unused IDL identifier for the name."""
        chosen = f"x{name}" if name.startswith("_") else name
        while chosen.lower() in self._taken:
            chosen += "_"
        self._taken.add(chosen.lower())
        return chosen


def common_fields(name: ScopedName, declaration: TecsDeclaration) -> dict[str, Any]:
    """Return the common fields of a declaration."""
    return {
        "name": name,
        "repository_id": default_id(name),
        "file": declaration.file,
        "span": declaration.span,
        "doc": declaration.doc,
    }


class AnonymousTypes(msgspec.Struct, eq=False):
    """Names the anonymous types of operations by typedefs inside the interface."""

    _interface: ScopedName
    _signature: TecsDeclaration
    _names: IdlNames
    _named: dict[Type, NamedType] = {}
    typedefs: list[Declaration] = []
    arrays: dict[Span, ScopedName] = {}

    def named(self, type_: Type) -> Type:
        """Return the type in a form valid for a parameter or return value."""
        if not isinstance(type_, SequenceType | ArrayType):
            return type_
        if type_ not in self._named:
            name = (*self._interface, self._names.add(_title(type_)))
            self._named[type_] = NamedType(name)
            common = common_fields(name, self._signature) | {"doc": ""}
            self.typedefs.append(Typedef(**common, type=type_))
        return self._named[type_]


def _title(type_: Type) -> str:
    """Return a name: `LongSeq` for `sequence<long>`, `OctetArray2x3` for `octet[2][3]`."""
    match type_:
        case SequenceType(element, bound):
            return f"{_title(element)}Seq{'' if bound is None else bound}"
        case ArrayType(element, dimensions):
            return f"{_title(element)}Array{'x'.join(map(str, dimensions))}"
        case NamedType(name):
            return name[-1][:1].upper() + name[-1][1:]
    return "".join(word[:1].upper() + word[1:] for word in str(type_).split())
