"""Results of name resolution, as tables beside the tree."""

from __future__ import annotations

import msgspec

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.names.scopes import Entity, Scope
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Repeated, Unit
from rtgen.compiler.model import Primitive, ScopedName

IDL_4_TYPES = {
    "int8": Primitive.INT8,
    "uint8": Primitive.UINT8,
    "int16": Primitive.SHORT,
    "uint16": Primitive.UNSIGNED_SHORT,
    "int32": Primitive.LONG,
    "uint32": Primitive.UNSIGNED_LONG,
    "int64": Primitive.LONG_LONG,
    "uint64": Primitive.UNSIGNED_LONG_LONG,
}
"""Integer names of IDL 4 that are not keywords: a declaration of the name takes precedence."""

CORBA_TYPES = {
    "CORBA::Object": Primitive.OBJECT,
    "CORBA::TypeCode": Primitive.TYPE_CODE,
}
"""Predefined members of module CORBA: a declaration takes precedence."""


class Tables(msgspec.Struct, eq=False):
    """Results of name resolution of a translation unit.

    `references` has None for names that were reported, and a Primitive for IDL 4's integers;
    `annotations` are those declared by `@annotation`, with their members; `modules` are the
    openings of modules that have annotations; `undefined` has a diagnostic for each interface
    without a definition, which another file may contain. `units` are in the order of their ends,
    with the inclusions that add nothing among them. `marks` assigns names to units: each mark
    is a unit, with the number of entities and references before its first ones. `openings` are the
    bodies of modules. `leading` are the units before which those that include them have nothing of
    their own, with the number of declarations and the last one when their ends were reached: what
    is known then depends on the leading units alone.
    """

    top: Scope
    references: dict[tree.ScopedName, Entity | Primitive | None] = msgspec.field(
        default_factory=dict
    )
    entities: dict[tree.Name, Entity] = msgspec.field(default_factory=dict)
    declared: list[Entity] = msgspec.field(default_factory=list)
    annotations: dict[str, tuple[str, ...]] = msgspec.field(default_factory=dict)
    units: list[Unit | Repeated] = msgspec.field(default_factory=list)
    modules: list[tuple[tree.Item, Unit]] = msgspec.field(default_factory=list)
    undefined: dict[ScopedName, Diagnostic] = msgspec.field(default_factory=dict)
    openings: dict[tree.Name, tree.Body] = msgspec.field(default_factory=dict)
    marks: list[tuple[Unit, int, int]] = msgspec.field(default_factory=list)
    leading: list[tuple[Unit, int, Entity | None]] = msgspec.field(default_factory=list)

    def mark(self, unit: Unit) -> None:
        """Record that the following names belong to a unit."""
        self.marks.append((unit, len(self.entities), len(self.references)))
