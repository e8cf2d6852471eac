"""Entities of a unit under analysis: celltypes, composites, cells and joins."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Protocol, TypeAlias

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.cdl.names.scopes import Entity, Kind, Scope
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.unit import Unit
from rtgen.compiler.frontends.kit.nodes import Spanned
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model.c_types import CType, Expression
from rtgen.compiler.model.tecs import Signature
from rtgen.compiler.model.types import ScopedName

DECLARE = "declare it before, or import the file that does"
"""Hint for an unknown name without a similar declared one."""

Report: TypeAlias = Callable[[Diagnostic], None]


def component(entity: Entity | Scope | None) -> object:
    """Return the celltype, composite or cell of an entity; None for an invalid or other entity."""
    return entity.component if isinstance(entity, Entity) else None


def here(entity: Entity | Scope, label: str = "declared here") -> list[Related]:
    """Return the place of a declaration as related information, if it has one."""
    return [] if entity.place is None else [Related(entity.place, label)]


class Place(msgspec.Struct, frozen=True):
    """Place of a node: its file, and the scope in which its names are looked up."""

    unit: Unit
    scope: Scope

    def span(self, node: Spanned) -> Span:
        """Return the span of a node."""
        return self.unit.span(node.start, node.end)

    def doc(self, node: Spanned) -> str:
        """Return the doc comment of a node."""
        return self.unit.source.docs.of(node.start, node.end)

    def lookup(self, name: tree.ScopedName) -> Entity | Scope | None:
        """Return the entity or scope of a name, seen from this place; None if it is unknown."""
        return self.scope.find(name)

    def near(self, name: tree.Name, *kinds: Kind) -> str | None:
        """Return a hint with a similar visible name of those kinds; None if there is none."""
        similar = nearest(
            name.text,
            (
                key
                for scope in self.scope.outwards()
                for table in (scope.entities, scope.scopes)
                for key, entity in table.items()
                if entity.kind in kinds
            ),
        )
        return f"did you mean {similar}?" if similar else None

    def may_be_declared(self, name: tree.ScopedName) -> bool:
        """Return whether a statement with a syntax error may have declared the name."""
        return name.parts[-1].text in self.unit.maybe_declared


class Declared(msgspec.Struct, frozen=True):
    """One name of a declaration: its type (None if it has errors) and its initialiser."""

    name: tree.Name
    type: CType | None
    value: tree.Initialiser | None


class Values(Protocol):
    """Types, constants and initialisers, as the passes over components use them."""

    @property
    def incomplete(self) -> bool:
        """Whether an import is missing, so that unknown names may be declared there."""

    def declare(self, declaration: tree.Declaration, place: Place) -> list[Declared]:
        """Return the names declared by attributes or variables; reports errors."""

    def constant(
        self, expression: tree.Expression, place: Place, names: Names | None = None
    ) -> object:
        """Return the value of a constant expression; None, without a diagnostic, if it has none."""

    def initial(
        self,
        type_: CType,
        value: tree.Initialiser,
        place: Place,
        types: Mapping[str, CType],
    ) -> Expression | None:
        """Return the model of an initialiser of the type; None, after a diagnostic, if invalid.

        `types` are those of the attributes that it may use.
        """

    def expression(
        self, expression: tree.Expression, place: Place, types: Mapping[str, CType]
    ) -> Expression | None:
        """Return the model of an expression; None, after a diagnostic, if it has errors."""


Names: TypeAlias = Callable[[str], "tuple[tree.Initialiser, Place] | None"]
"""Initialisers of the attributes that an expression may name, with their places."""


class HiddenFor(msgspec.Struct, eq=False):
    """The parameter whose allocator an implicit call port is for."""

    port: Port
    function: str
    parameter: str


class Port(msgspec.Struct, eq=False):
    """A call port or entry port of a celltype or composite."""

    name: str
    kind: str
    signature: Signature | None
    signature_name: ScopedName
    span: Span
    array: bool = False
    size: int | None = None
    flags: set[str] = msgspec.field(default_factory=set)
    required: Entity | None = None
    required_port: str = ""
    hidden: HiddenFor | None = None
    allocations: tuple[tree.Allocation, ...] = ()
    allocators: dict[tuple[str, str], Allocator] = msgspec.field(default_factory=dict)
    fixed: statements.PortOf | None = None
    fixed_place: Place | None = None

    @property
    def optional(self) -> bool:
        """Whether a join may be missing."""
        return "optional" in self.flags

    @property
    def omitted(self) -> bool:
        """Whether the port has no functions to call: `omit`, or an empty signature."""
        return "omit" in self.flags or self.empty

    @property
    def empty(self) -> bool:
        """Whether the signature has no functions."""
        return self.signature is not None and not self.signature.functions

    def parameters(self) -> Iterator[tuple[str, str, tuple[str, ...]]]:
        """Yield function, parameter and allocator signature of each send and receive parameter."""
        for function in self.signature.functions if self.signature else ():
            for parameter in function.parameters:
                if parameter.allocator is not None:
                    yield function.name, parameter.name, parameter.allocator


class Allocator(msgspec.Struct, eq=False):
    """`function.parameter <= call.function.parameter`, or `= entry` where `call` is empty."""

    node: tree.Allocation
    call: str = ""
    function: str = ""
    parameter: str = ""
    entry: str = ""


class Variable(msgspec.Struct, eq=False):
    """An attribute or, as `kind` says (`attr` or `var`), a variable."""

    name: str
    kind: str
    type: CType | None
    value: tree.Initialiser | None
    place: Place
    span: Span
    size_is: tree.Expression | None = None
    initial: Expression | None = None
    size: Expression | None = None
    omit: bool = False
    choice: tuple[str, ...] = ()


Member: TypeAlias = Port | Variable


class Celltype(msgspec.Struct, eq=False):
    """A celltype, or a composite (`Composite`)."""

    entity: Entity
    place: Place
    singleton: bool = False
    active: bool = False
    idx_is_id: bool = False
    members: dict[str, Member] = msgspec.field(default_factory=dict)
    cell_factory: bool = False
    celltype_factory: bool = False
    cells: list[Cell] = msgspec.field(default_factory=list)
    joined_by: str | None = None
    """The plug-in that may join call ports of the cells."""

    @property
    def name(self) -> str:
        """The name alone."""
        return self.entity.name[-1]

    @property
    def ports(self) -> list[Port]:
        """The ports, including implicit ones of `require` and allocators."""
        return [m for m in self.members.values() if isinstance(m, Port)]

    @property
    def variables(self) -> list[Variable]:
        """The attributes and variables."""
        return [m for m in self.members.values() if isinstance(m, Variable)]

    @property
    def inactive(self) -> bool:
        """Whether cells have an effect only when they are called."""
        factory = self.cell_factory or (self.singleton and self.celltype_factory)
        return not self.active and not factory

    def real(self) -> Counter[Celltype]:
        """Return the celltypes of the simple cells that a cell expands to, with their number."""
        return Counter([self])

    def fixed(self) -> Sequence[tuple[Port, str]]:
        """Return the ports with a fixed join, by their names in this celltype."""
        return [(port, port.name) for port in self.ports if port.fixed is not None]


class Exported(msgspec.Struct, eq=False):
    """A port or attribute of an inner cell that a composite exports."""

    name: str
    cell: Cell
    member: str
    span: Span


class _Inside(msgspec.Struct, eq=False):
    """Summary of the inner cells of a composite."""

    real: Counter[Celltype] = msgspec.field(default_factory=Counter)
    inactive: bool = True
    fixed: list[tuple[Port, str]] = msgspec.field(default_factory=list)
    kept: list[Port] = msgspec.field(default_factory=list)
    levels: int = 1


class Composite(Celltype, eq=False):
    """A composite with its inner cells. `reported`: names with an invalid export."""

    inner: dict[str, Cell] = msgspec.field(default_factory=dict)
    reported: set[str] = msgspec.field(default_factory=set)
    exports: list[Exported] = msgspec.field(default_factory=list)
    _inside: _Inside = msgspec.field(default_factory=_Inside)

    def export(self, name: str) -> Exported | None:
        """Return the first export of that name."""
        return next((e for e in self.exports if e.name == name), None)

    @property
    def inactive(self) -> bool:
        """Whether none of the inner cells runs by itself."""
        return not self.active and self._inside.inactive

    def real(self) -> Counter[Celltype]:
        """Return the celltypes of the inner cells, with nested composites expanded."""
        return self._inside.real

    def fixed(self) -> Sequence[tuple[Port, str]]:
        """Return the ports with a fixed join, those of inner cells under their outer names."""
        return [*Celltype.fixed(self), *self._inside.fixed]

    def kept(self) -> Sequence[Port]:
        """Return the ports with a fixed join that inner cells do not export."""
        return self._inside.kept

    @property
    def levels(self) -> int:
        """The nesting depth of composites."""
        return self._inside.levels

    def close(self) -> None:
        """Summarize the inner cells once all of them are read."""
        inside = _Inside()
        ports: dict[Port, None] = {}
        for cell in self.inner.values():
            type_ = cell.celltype
            if type_ is None:
                continue
            inside.real.update(type_.real())
            inside.inactive = inside.inactive and type_.inactive
            for port, name in type_.fixed():
                if name in cell.exported:
                    inside.fixed.append((port, cell.exported[name].name))
                else:
                    ports[port] = None
            if isinstance(type_, Composite):
                inside.levels = max(inside.levels, type_.levels + 1)
                ports.update(dict.fromkeys(type_.kept()))
        inside.kept = list(ports)
        self._inside = inside


class Plugin(msgspec.Struct, frozen=True):
    """A plug-in on a join, as written; `region`: the region that specifies it, if one does."""

    name: tree.Name
    argument: tree.Text
    place: Place
    origin: str = "through"
    region: Scope | None = None
    count: int = 0


class Join(msgspec.Struct, eq=False):
    """A join or attribute value of a cell. `index`: -1 for `[]`, None without a subscript.

    `value` is the value as written, which names the target. For a join made for `require`, a
    reverse or fixed join, or an allocator, `target` is set instead. `made` is the name of a target
    that a plug-in may generate; `port` is the call port then.
    """

    name: str
    index: int | None
    span: Span
    place: Place
    value: tree.Initialiser | tree.OfComposite | None = None
    target: Target | None = None
    plugins: tuple[Plugin, ...] = ()
    cell: Cell | None = None
    made: ScopedName = ()
    port: Port | None = None
    port_name: str = ""
    port_index: int | None = None
    chain: tuple[Plugin, ...] = ()
    initial: Expression | None = None
    done: bool = False


class Target(msgspec.Struct, frozen=True):
    """The right side of a join: the name or the cell itself, the entry port, its subscript."""

    cell: tree.ScopedName | Cell
    port: str
    index: int | None
    span: Span
    port_span: Span
    place: Place


class CellAllocator(msgspec.Struct, frozen=True):
    """An allocator of an entry port of a cell: the parameter, and the target of its joins."""

    port: str
    index: int | None
    function: str
    parameter: str
    join: Join


class Cell(msgspec.Struct, eq=False):
    """A cell; only its prototype until it is `defined`.

    `guessed`: the celltype is unknown and may have been declared by a plug-in. `assigned` are ports
    and attributes that the cell sets, `clashing` those that it sets twice.
    """

    entity: Entity
    celltype: Celltype | None
    celltype_name: tree.ScopedName
    place: Place
    region: Scope
    inside: Composite | None = None
    order: list[Join] = msgspec.field(default_factory=list)
    joins: dict[str, list[Join]] = msgspec.field(default_factory=dict)
    reversed: list[tuple[statements.ReverseJoin, Place]] = msgspec.field(
        default_factory=list
    )
    allocators: list[CellAllocator] = msgspec.field(default_factory=list)
    exported: dict[str, Exported] = msgspec.field(default_factory=dict)
    plugins: list[tree.Name] = msgspec.field(default_factory=list)
    defined: bool = False
    span: Span | None = None
    used: bool = False
    resolved: bool = False
    guessed: bool = False
    assigned: set[str] = msgspec.field(default_factory=set)
    clashing: set[str] = msgspec.field(default_factory=set)
    callers: dict[str, int] = msgspec.field(default_factory=dict)
    id: int | None = None
    id_span: Span | None = None

    @property
    def name(self) -> str:
        """The name alone."""
        return self.entity.name[-1]
