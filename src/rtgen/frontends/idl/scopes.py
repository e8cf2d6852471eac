"""Scopes and what is declared in them (CORBA 2.6, 3.15; OMG IDL 4.2, 7.5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

from rtgen.diagnostics import Span
from rtgen.frontends.idl import tree
from rtgen.frontends.idl.unit import Unit
from rtgen.model import ScopedName


class Kind(StrEnum):
    """What a name stands for; the value is how messages call it."""

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
"""What can be the type of something; exceptions cannot."""


@dataclass(eq=False, slots=True)
class Entity:
    """Something with a name. `node` is its definition, None while only forward-declared.

    `type_node` is the type behind a typedef, a member or a constant, with its `declarator`.
    `contradicted` says that another declaration of the name is of another kind or prefix,
    `clashes` that its name, or that of what it stands in, is taken: it is kept out of its scope.
    `default_id` is the repository id but for `#pragma ID` and `version`.
    `order` counts the declarations of the translation unit; `modifier` is abstract, local, custom.
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
        """The name from the global scope down."""
        return "::".join(self.path)

    @property
    def span(self) -> Span:
        """Where its name stands."""
        return self.unit.span(self.start, self.end)


@dataclass(frozen=True, slots=True)
class Use:
    """The use of a name that introduced it into a scope."""

    entity: Entity
    unit: Unit
    start: int
    end: int

    @property
    def span(self) -> Span:
        """Where it was used."""
        return self.unit.span(self.start, self.end)


@dataclass(eq=False, slots=True)
class Scope:
    """The names of a scope, by the keys of the look-up: lower-case forms, as a rule.

    `ids` is the path of repository ids; `around` are the openings of modules with annotations that
    what is declared now stands in, the innermost last; `lacking` says that a base is not known.
    """

    entity: Entity | None
    parent: Scope | None
    ids: str = ""
    names: dict[str, Entity] = field(default_factory=dict)
    introduced: dict[str, Use] = field(default_factory=dict)
    bases: list[Scope] = field(default_factory=list)
    imported: list[Scope] = field(default_factory=list)
    around: tuple[tree.Item, ...] = ()
    lacking: bool = False

    @property
    def path(self) -> ScopedName:
        """The scoped name of what the scope belongs to; empty for the global scope."""
        return () if self.entity is None else self.entity.path

    def outward(self) -> Iterator[Scope]:
        """This scope, then those around it."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def find(self, key: str) -> list[Entity]:
        """What `key` may mean here: own before inherited, more if ambiguous."""
        own = self.names.get(key)
        if own is not None:
            return [own]
        found = self.inherited(key)
        for scope in self.imported if not found else ():
            if key in scope.names:
                found.append(scope.names[key])
        return found

    def inherited(self, key: str) -> list[Entity]:
        """What bases declare under `key`; a declaration hides those of its own bases."""
        if not self.bases:
            return []
        found: dict[Entity, None] = {}
        seen: set[Scope] = set()
        pending = list(reversed(self.bases))
        while pending:
            scope = pending.pop()
            if scope in seen:
                continue
            seen.add(scope)
            entity = scope.names.get(key)
            if entity is not None:
                found[entity] = None
            else:
                pending.extend(reversed(scope.bases))
        return list(found)

    @property
    def doubtful(self) -> bool:
        """Whether a name that is not here may be inherited from what is not known."""
        return self.lacking or any(base.lacking for base in self.all_bases())

    def all_bases(self) -> list[Scope]:
        """Every base, direct or not, once, nearest first."""
        seen: dict[Scope, None] = {}
        pending = list(reversed(self.bases))
        while pending:
            scope = pending.pop()
            if scope not in seen:
                seen[scope] = None
                pending.extend(reversed(scope.bases))
        return list(seen)
