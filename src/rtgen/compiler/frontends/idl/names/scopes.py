"""Scopes and their declarations (CORBA 2.6, 3.15; OMG IDL 4.2, 7.5)."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.model import ScopedName


class Kind(StrEnum):
    """Kinds of declarations; the value is their name in messages."""

    __hash__ = str.__hash__

    MODULE = "module"
    STRUCT = "struct"
    UNION = "union"
    EXCEPTION = "exception"
    ENUM = "enum"
    ENUMERATOR = "enumerator"
    BITSET = "bitset"
    BITMASK = "bitmask"
    TYPEDEF = "typedef"
    CONST = "constant"
    NATIVE = "native type"
    INTERFACE = "interface"
    VALUETYPE = "valuetype"
    VALUE_BOX = "value box"
    COMPONENT = "component"
    HOME = "home"
    OPERATION = "operation"
    ATTRIBUTE = "attribute"
    MEMBER = "member"
    PARAMETER = "parameter"
    PORT = "port"
    UNUSED = "declaration"


TYPES = frozenset(
    (
        *(Kind.STRUCT, Kind.UNION, Kind.ENUM, Kind.BITSET, Kind.BITMASK, Kind.TYPEDEF),
        *(Kind.NATIVE, Kind.INTERFACE, Kind.VALUETYPE, Kind.VALUE_BOX, Kind.COMPONENT),
        Kind.HOME,
    )
)
"""Kinds that can be the type of a value; exceptions cannot."""


class Entity(msgspec.Struct, eq=False):
    """A declared name. `node` is its definition, None while only forward-declared.

    `type_node` is the type of a typedef, a member or a constant, with its `declarator`.
    `contradicted`: another declaration of the name has another kind or prefix; `clashes`: its
    name, or that of an enclosing scope, is already used, so it is kept out of its scope.
    `default_id` is the repository id without `#pragma ID` and `version`. `order` counts the
    declarations of the translation unit; `modifier` is abstract, local, custom.
    """

    name: str
    kind: Kind
    scope: Scope
    unit: Unit
    start: int
    end: int
    path: ScopedName
    order: int
    repository_id: str = ""
    node: object = None
    type_node: tree.TypeNode | None = None
    declarator: tree.Declarator | None = None
    inner: Scope | None = None
    complete: bool = True
    modifier: str = ""
    poisoned: bool = False
    contradicted: bool = False
    clashes: bool = False
    fixed_id: Span | None = None
    fixed_version: Span | None = None
    prefix: str | None = None
    owner: Entity | None = None
    annotations: tuple[tree.Annotation, ...] = ()
    item: tree.Item | None = None
    around: tuple[tree.Item, ...] = ()
    default_id: str = ""

    @property
    def scoped(self) -> str:
        """The scoped name from the global scope."""
        return "::".join(self.path)

    @property
    def span(self) -> Span:
        """The place of its name."""
        return self.unit.span(self.start, self.end)


class Use(msgspec.Struct, frozen=True):
    """A use of a name that introduced it into a scope."""

    entity: Entity
    unit: Unit
    start: int
    end: int

    @property
    def span(self) -> Span:
        """The place of the use."""
        return self.unit.span(self.start, self.end)


class Scope(msgspec.Struct, eq=False):
    """The names of a scope by look-up key: usually their lower-case form.

    `ids` is the path of repository ids; `around` are the enclosing openings of modules with
    annotations, innermost last; `lacking`: a base is unknown.
    """

    entity: Entity | None
    parent: Scope | None
    ids: str = ""
    names: dict[str, Entity] = msgspec.field(default_factory=dict)
    introduced: dict[str, Use] = msgspec.field(default_factory=dict)
    bases: list[Scope] = msgspec.field(default_factory=list)
    imported: list[Scope] = msgspec.field(default_factory=list)
    around: tuple[tree.Item, ...] = ()
    lacking: bool = False

    @property
    def path(self) -> ScopedName:
        """The scoped name of the scope's owner; empty for the global scope."""
        return () if self.entity is None else self.entity.path

    def outward(self) -> Iterator[Scope]:
        """This scope, then the enclosing ones."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def find(self, key: str) -> list[Entity]:
        """Return the candidates for `key`: own before inherited; several if ambiguous."""
        own = self.names.get(key)
        if own is not None:
            return [own]
        entities = self.inherited(key)
        for scope in self.imported if not entities else ():
            if key in scope.names:
                entities.append(scope.names[key])
        return entities

    def inherited(self, key: str) -> list[Entity]:
        """Return the inherited declarations of `key`; a base's hides those of its own bases."""
        if not self.bases:
            return []
        entities: dict[Entity, None] = {}
        seen: set[Scope] = set()
        pending = list(reversed(self.bases))
        while pending:
            scope = pending.pop()
            if scope in seen:
                continue
            seen.add(scope)
            entity = scope.names.get(key)
            if entity is not None:
                entities[entity] = None
            else:
                pending.extend(reversed(scope.bases))
        return list(entities)

    @property
    def doubtful(self) -> bool:
        """Whether an unknown name may be inherited from an unknown base."""
        return self.lacking or any(base.lacking for base in self.all_bases())

    def all_bases(self) -> list[Scope]:
        """Return all direct and indirect bases, each once, nearest first."""
        seen: dict[Scope, None] = {}
        pending = list(reversed(self.bases))
        while pending:
            scope = pending.pop()
            if scope not in seen:
                seen[scope] = None
                pending.extend(reversed(scope.bases))
        return list(seen)
