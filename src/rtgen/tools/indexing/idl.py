"""Names of IDL, from the tables of name resolution."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.idl.names import scopes
from rtgen.compiler.frontends.idl.names.scopes import Entity
from rtgen.compiler.frontends.idl.names.tables import Tables
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import ScopedName
from rtgen.tools.indexing.index import Collector, Kind, path_of

_KINDS = {
    scopes.Kind.MODULE: Kind.MODULE,
    scopes.Kind.STRUCT: Kind.STRUCT,
    scopes.Kind.UNION: Kind.UNION,
    scopes.Kind.EXCEPTION: Kind.EXCEPTION,
    scopes.Kind.ENUM: Kind.ENUM,
    scopes.Kind.ENUMERATOR: Kind.ENUMERATOR,
    scopes.Kind.BITSET: Kind.STRUCT,
    scopes.Kind.BITMASK: Kind.BITS,
    scopes.Kind.TYPEDEF: Kind.TYPEDEF,
    scopes.Kind.CONST: Kind.CONSTANT,
    scopes.Kind.NATIVE: Kind.TYPEDEF,
    scopes.Kind.INTERFACE: Kind.INTERFACE,
    scopes.Kind.VALUETYPE: Kind.STRUCT,
    scopes.Kind.VALUE_BOX: Kind.TYPEDEF,
    scopes.Kind.COMPONENT: Kind.COMPONENT,
    scopes.Kind.HOME: Kind.COMPONENT,
    scopes.Kind.OPERATION: Kind.OPERATION,
    scopes.Kind.ATTRIBUTE: Kind.ATTRIBUTE,
    scopes.Kind.MEMBER: Kind.MEMBER,
    scopes.Kind.PARAMETER: Kind.PARAMETER,
    scopes.Kind.PORT: Kind.PORT,
    scopes.Kind.UNUSED: Kind.MODULE,
}
_MAX_DETAIL = 80

Definition: TypeAlias = tuple[str, str, Kind, Span, Span | None, str, str]
"""Key, name, kind, place of the name, extent, container and detail of a definition."""


def key_of(name: ScopedName) -> str:
    """Return the key of a scoped name of IDL."""
    return "idl " + "::".join(name)


class FileNames(msgspec.Struct, frozen=True, eq=False):
    """The names of a file of a translation unit: arguments of `Collector.define` and `refer`."""

    file: tuple[str, str]
    definitions: tuple[Definition, ...]
    uses: tuple[tuple[str, Span], ...]


class IdlNames:
    """Adds the names of translation units; a file included by several units is added once."""

    def __init__(self, collector: Collector) -> None:
        self._collector = collector
        self._added: dict[tuple[str, str], FileNames] = {}

    def names(self, tables: Tables) -> tuple[FileNames, ...]:
        """Return the names of a translation unit; those of files that were added are the same."""
        entities = list(tables.entities.items())
        references = list(tables.references.items())
        marks = [*tables.marks, (None, len(entities), len(references))]
        files: dict[tuple[str, str], FileNames | _File] = {}
        for (unit, first, begin), (_, last, end) in pairwise(marks):
            assert unit is not None
            identity = unit.source.name, unit.text
            if identity not in files:
                files[identity] = self._added.get(identity) or _File(identity, unit)
            file = files[identity]
            if isinstance(file, _File):
                for name, entity in entities[first:last]:
                    file.entity(name, entity, unit, tables.openings.get(name))
                for reference, target in references[begin:end]:
                    if isinstance(target, Entity):
                        file.reference(reference, target, unit)
        return tuple(
            each.names() if isinstance(each, _File) else each for each in files.values()
        )

    def add(self, names: Iterable[FileNames]) -> None:
        """Add the names of a translation unit."""
        for file in names:
            if file.file in self._added:
                continue
            self._added[file.file] = file
            for key, name, kind, span, extent, container, detail in file.definitions:
                self._collector.define(
                    *(key, name, kind, span, extent),
                    container=container,
                    detail=detail,
                )
            for key, span in file.uses:
                self._collector.refer(key, span)


class _File:
    """Collects the names of a file."""

    def __init__(self, identity: tuple[str, str], unit: Unit) -> None:
        self._identity = identity
        self._definitions: list[Definition] = []
        self._uses = [(f"file {path_of(name)}", span) for name, span in unit.inclusions]

    def names(self) -> FileNames:
        """Return all."""
        definitions, uses = tuple(self._definitions), tuple(self._uses)
        return FileNames(self._identity, definitions, uses)

    def entity(
        self, name: tree.Name, entity: Entity, unit: Unit, opening: tree.Body | None
    ) -> None:
        """Collect a declaration."""
        span = unit.span(name.start, name.end)
        key = key_of(entity.path)
        here = (name.start, unit) == (entity.start, entity.unit)
        if not here and opening is None:
            self._uses.append((key, span))  # a forward declaration
            return
        extent = _extent(entity, unit) if here else None
        if opening is not None:
            extent = unit.span(name.start, opening.end + 1)
        container = key_of(entity.path[:-1]) if entity.path[:-1] else ""
        detail = _detail(entity, unit)
        kind = _KINDS[entity.kind]
        self._definitions.append(
            (key, entity.name, kind, span, extent, container, detail)
        )

    def reference(self, name: tree.ScopedName, target: Entity, unit: Unit) -> None:
        """Collect the use of a name."""
        for part, entity in _parts(name, target):
            key = key_of(entity.path)
            self._uses.append((key, unit.span(part.start, part.end)))


def _parts(name: tree.ScopedName, target: Entity) -> Iterator[tuple[tree.Name, Entity]]:
    """Yield the parts of a scoped name with their entities, the last one first."""
    entity: Entity | None = target
    for part in reversed(name.parts):
        if entity is None or entity.name != part.text:
            return
        yield part, entity
        entity = entity.scope.entity


def _extent(entity: Entity, unit: Unit) -> Span | None:
    """Return the span of a whole definition."""
    node = entity.item
    if node is not None:
        return unit.span(node.start, node.end)
    if isinstance(entity.node, tree.Enumerator | tree.PortItem | tree.Declarator):
        return unit.span(entity.node.start, entity.node.end)
    return None


def _detail(entity: Entity, unit: Unit) -> str:
    """Return the type of a member, parameter, typedef or port, as written."""
    node: object = entity.type_node
    if isinstance(entity.node, tree.PortItem | tree.Operation):
        node = entity.node.type
    if node is None or isinstance(node, tree.Struct | tree.Union | tree.Enum):
        return ""
    start, end = getattr(node, "start", 0), getattr(node, "end", 0)
    text = " ".join(unit.text[start:end].split())
    return text if len(text) <= _MAX_DETAIL else text[:_MAX_DETAIL] + "..."
