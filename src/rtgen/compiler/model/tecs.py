"""TECS component descriptions (CDL), resolved: signatures, celltypes, cells and joins."""

from __future__ import annotations

from enum import StrEnum
from functools import cached_property

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.c_types import CType, Expression
from rtgen.compiler.model.types import ScopedName


class TecsDirection(StrEnum):
    """The direction specifier of a parameter."""

    IN = "in"
    OUT = "out"
    INOUT = "inout"
    SEND = "send"
    RECEIVE = "receive"

    @property
    def inward(self) -> bool:
        """Whether the value travels with the request."""
        return self in _INWARD

    @property
    def outward(self) -> bool:
        """Whether the value travels with the reply."""
        return self in _OUTWARD


_INWARD = frozenset({TecsDirection.IN, TecsDirection.INOUT, TecsDirection.SEND})
_OUTWARD = frozenset({TecsDirection.OUT, TecsDirection.INOUT, TecsDirection.RECEIVE})


class Sizes(msgspec.Struct, frozen=True, kw_only=True):
    """Size specifiers of a parameter or struct member.

    `string` is None without the specifier; `unsized_string`: `string` without an argument.
    `max_size` is the second argument of `size_is`, a constant.
    """

    size_is: Expression | None = None
    max_size: int | None = None
    count_is: Expression | None = None
    string: Expression | None = None
    unsized_string: bool = False
    nullable: bool = False

    @property
    def is_string(self) -> bool:
        """Whether there is a `string` specifier."""
        return self.string is not None or self.unsized_string


class TecsParameter(msgspec.Struct, frozen=True, kw_only=True):
    """A parameter of a function. `allocator` is the signature of send and receive."""

    name: str
    type: CType
    direction: TecsDirection
    sizes: Sizes = Sizes()
    allocator: ScopedName | None = None
    span: Span
    doc: str = ""


class TecsFunction(msgspec.Struct, frozen=True, kw_only=True):
    """A function of a signature; `id` counts from 1 in the order of the text."""

    id: int
    name: str
    returns: CType
    parameters: tuple[TecsParameter, ...] = ()
    oneway: bool = False
    span: Span
    doc: str = ""


class TecsDeclaration(msgspec.Struct, frozen=True, kw_only=True):
    """Attributes of all named declarations of CDL: scoped name, file, place."""

    name: ScopedName
    file: str
    span: Span
    doc: str = ""

    @property
    def scoped(self) -> str:
        """The name as CDL writes it, without a leading `::`."""
        return "::".join(self.name)

    @property
    def global_name(self) -> str:
        """The name in C."""
        return "_".join(self.name)


class TecsMember(msgspec.Struct, frozen=True, kw_only=True):
    """A member of a struct."""

    name: str
    type: CType
    sizes: Sizes = Sizes()
    span: Span
    doc: str = ""


class TecsStruct(TecsDeclaration, frozen=True, kw_only=True):
    """A struct by its tag; `from_c`: declared in a C header."""

    members: tuple[TecsMember, ...]
    from_c: bool = False


class TecsTypedef(TecsDeclaration, frozen=True, kw_only=True):
    """A typedef; `from_c`: declared in a C header or in the prelude."""

    type: CType
    from_c: bool = False


class TecsEnum(TecsDeclaration, frozen=True, kw_only=True):
    """An enum with its values."""

    members: tuple[tuple[str, int], ...]
    bits: int | None = None


class TecsConst(TecsDeclaration, frozen=True, kw_only=True):
    """A constant; `value` is None for a pointer constant that only C can evaluate."""

    type: CType
    value: bool | int | float | str | None


class Signature(TecsDeclaration, frozen=True, kw_only=True):
    """A set of functions. `context` is `task`, `non-task` or `any`."""

    functions: tuple[TecsFunction, ...]
    context: str = "task"
    callback: bool = False
    deviate: bool = False


class TecsPort(msgspec.Struct, frozen=True, kw_only=True):
    """A call port or entry port (`kind` is `call` or `entry`).

    `size` of an array is None for `[]`. Two kinds of call ports are implicit: `required` ones
    come from `require`, `hidden` ones are for the allocator of a send or receive parameter.
    """

    name: str
    kind: str
    signature: ScopedName
    array: bool = False
    size: int | None = None
    optional: bool = False
    omit: bool = False
    dynamic: bool = False
    ref_desc: bool = False
    inline: bool = False
    required: bool = False
    hidden: bool = False
    span: Span


class TecsVariable(msgspec.Struct, frozen=True, kw_only=True):
    """An attribute or variable of a celltype, with its initialiser."""

    name: str
    type: CType
    initial: Expression | None = None
    size_is: Expression | None = None
    omit: bool = False
    choice: tuple[str, ...] = ()
    span: Span


class Celltype(TecsDeclaration, frozen=True, kw_only=True):
    """A celltype."""

    ports: tuple[TecsPort, ...] = ()
    attributes: tuple[TecsVariable, ...] = ()
    variables: tuple[TecsVariable, ...] = ()
    singleton: bool = False
    active: bool = False
    idx_is_id: bool = False


class TextPiece(msgspec.Struct, frozen=True):
    """A piece of a concatenated string: it starts at `offset` of the text, `span` is its source."""

    offset: int
    span: Span


class PluginArgument(msgspec.Struct, frozen=True):
    """The argument string of a plug-in, adjacent literals joined, escapes as written."""

    text: str
    pieces: tuple[TextPiece, ...]

    def span_of(self, start: int, end: int) -> Span:
        """Return the source of `text[start:end]`; of its first piece if there are several."""
        piece = self.pieces[0]
        for candidate in self.pieces:
            if candidate.offset <= start:
                piece = candidate
        span = piece.span
        first = span.column + start - piece.offset
        last = min(span.column + end - piece.offset, span.end_column)
        return Span(span.file, span.line, first, span.line, max(last, first))


class PluginOption(msgspec.Struct, frozen=True):
    """`name = value` of a plug-in's argument: `value` without quotes, escapes and `$...$`."""

    name: str
    value: str
    span: Span
    value_span: Span


class Through(msgspec.Struct, frozen=True, kw_only=True):
    """A plug-in of a join. `origin` is the kind of specifier that added it.

    `origin` is `through`, `out_through`, `to_through` or `in_through`; `region` is its region,
    for the last three. `options` are those of the argument, only parsed for rtgen's plug-in:
    tecsgen's plug-ins have their own syntax.
    """

    plugin: str
    argument: PluginArgument
    span: Span
    origin: str = "through"
    region: ScopedName = ()
    options: tuple[PluginOption, ...] = ()


class Join(msgspec.Struct, frozen=True, kw_only=True):
    """A resolved join of a call port to an entry port; `through` in the order from the caller.

    `index` is the subscript of the call port, None if it is not an array.
    """

    port: str
    index: int | None
    target: ScopedName
    target_port: str
    target_index: int | None
    signature: ScopedName
    through: tuple[Through, ...] = ()
    span: Span


class Cell(TecsDeclaration, frozen=True, kw_only=True):
    """A cell. `name` includes its regions; `attributes` are the values that the cell gives."""

    celltype: ScopedName
    region: ScopedName = ()
    joins: tuple[Join, ...] = ()
    attributes: tuple[tuple[str, Expression], ...] = ()


class Composite(TecsDeclaration, frozen=True, kw_only=True):
    """A composite celltype: its outer ports and attributes, and the inner cells.

    `exports` maps an outer port to its name, inner cell and inner port.
    """

    ports: tuple[TecsPort, ...] = ()
    attributes: tuple[TecsVariable, ...] = ()
    cells: tuple[Cell, ...] = ()
    exports: tuple[tuple[str, str, str], ...] = ()
    singleton: bool = False
    active: bool = False


class Region(TecsDeclaration, frozen=True, kw_only=True):
    """A region; `linkunit` and `node` start a separate executable."""

    linkunit: bool = False
    node: bool = False


class TecsUnit(msgspec.Struct, frozen=True, dict=True):
    """The declarations of a main CDL file and its imports, imports before importers.

    `file` is the displayed path of the main file, `key` the one for generated text.
    """

    file: str
    key: str
    declarations: tuple[TecsDeclaration, ...]

    @cached_property
    def structs(self) -> dict[ScopedName, TecsStruct]:
        """The structs by their tags."""
        return {d.name: d for d in self.declarations if isinstance(d, TecsStruct)}

    @cached_property
    def _by_kind(
        self,
    ) -> dict[tuple[ScopedName, type[TecsDeclaration]], TecsDeclaration]:
        return {(d.name, type(d)): d for d in self.declarations}

    def find(self, name: ScopedName, kind: type[TecsDeclaration]) -> TecsDeclaration:
        """Find a declaration by name and kind. Raises KeyError.

        Struct tags have a separate name space, so the kind is required.
        """
        return self._by_kind[name, kind]

    def joins_through(self, plugin: str) -> tuple[tuple[Cell, Join], ...]:
        """Return the joins through a plug-in of that name, in order of the text."""
        return tuple(
            (cell, join)
            for cell in self.declarations
            if isinstance(cell, Cell)
            for join in cell.joins
            if any(through.plugin == plugin for through in join.through)
        )
