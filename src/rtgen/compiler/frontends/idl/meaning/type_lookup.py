"""Interface to the type table for the evaluation of constants."""

from __future__ import annotations

from typing import Protocol

from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import ScopedName, Type


class TypeLookup(Protocol):
    """The part of `typetable.Types` that constants use."""

    tables: Tables

    def of_node(self, node: tree.TypeNode, unit: Unit, /) -> Type | None: ...

    def unaliased(self, type_: Type | None, /) -> Type | None: ...

    def is_enum(self, name: ScopedName, /) -> bool: ...

    def enum_of(self, enumerator: ScopedName, /) -> ScopedName | None: ...
