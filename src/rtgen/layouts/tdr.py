"""The layout of TECS OpaqueRPC messages: what travels in which order, and what it depends on.

A message is a tuple of steps. A `Run` is a stretch of values whose size is fixed once the TDR is
known; what depends on values read before comes between the runs. Expressions stay the
definition's.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import TypeAlias

from rtgen.diagnostics import Span
from rtgen.model.tecs import (
    AggregateExpression,
    BinaryExpression,
    CArrayType,
    CastExpression,
    CEnumType,
    ConditionalExpression,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    CTypedefType,
    Expression,
    Literal,
    Reference,
    Scalar,
    Signature,
    Sizes,
    TecsDirection,
    TecsFunction,
    TecsParameter,
    TecsStruct,
    TecsUnit,
    UnaryExpression,
    resolve,
)

KINDS = {
    Scalar.BOOL: "?",
    Scalar.CHAR: "B",
    Scalar.UCHAR: "B",
    Scalar.SCHAR: "b",
    Scalar.INT8: "b",
    Scalar.UINT8: "B",
    Scalar.INT16: "h",
    Scalar.UINT16: "H",
    Scalar.INT32: "i",
    Scalar.UINT32: "I",
    Scalar.INT64: "q",
    Scalar.UINT64: "Q",
    Scalar.LONG_LONG: "q",
    Scalar.ULONG_LONG: "Q",
    Scalar.INT128: "w",
    Scalar.UINT128: "W",
    Scalar.SHORT: "k",
    Scalar.USHORT: "K",
    Scalar.INT: "n",
    Scalar.UINT: "N",
    Scalar.LONG: "l",
    Scalar.ULONG: "L",
    Scalar.INTPTR: "p",
    Scalar.UINTPTR: "P",
    Scalar.FLOAT32: "f",
    Scalar.DOUBLE64: "d",
}
"""The letter of a basic type, as `rtgen.runtime.opaque_rpc.tdr` reads it; `w` and `W`: 128 bits."""

INTEGERS = frozenset(
    s for s in KINDS if s not in (Scalar.BOOL, Scalar.FLOAT32, Scalar.DOUBLE64)
)
"""The integer types."""

_OCTETS = (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR, Scalar.UINT8)
_TEXT_UNITS = frozenset("bBhHiIqQ")


class TransferError(Exception):
    """A parameter, a member or a return value that OpaqueRPC cannot carry; `hint` may help."""

    def __init__(self, span: Span, reason: str, hint: str | None = None) -> None:
        super().__init__(reason)
        self.span = span
        self.reason = reason
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Nothing:
    """`void`, behind pointers or not: no byte."""


@dataclass(frozen=True, slots=True)
class Basic:
    """A number or truth value."""

    scalar: Scalar

    @property
    def kind(self) -> str:
        """Its letter."""
        return KINDS[self.scalar]


@dataclass(frozen=True, slots=True)
class Octets:
    """A fixed array of octets or characters."""

    scalar: Scalar
    count: int


@dataclass(frozen=True, slots=True)
class FixedArray:
    """A fixed array of anything else."""

    element: Node
    count: int


@dataclass(frozen=True, slots=True)
class Record:
    """A struct; `items` in the order of the declaration, `steps` in that of the wire."""

    struct: TecsStruct
    items: tuple[Item, ...]
    steps: tuple[Step, ...]

    @property
    def fixed(self) -> bool:
        """Whether its size depends on no value."""
        return all(isinstance(step, Run) for step in self.steps)


@dataclass(frozen=True, slots=True)
class Counted:
    """An array behind a pointer: `count` elements travel, `size` fit; `most` bounds `size`."""

    element: Node
    size: Expression
    count: Expression
    most: int | None

    @property
    def scalar(self) -> Scalar | None:
        """The type of the elements if they are numbers or truth values."""
        return self.element.scalar if isinstance(self.element, Basic) else None

    @property
    def is_octets(self) -> bool:
        """Whether the array is one of octets or characters."""
        return self.scalar in _OCTETS


@dataclass(frozen=True, slots=True)
class String:
    """A string; `length` is the size of its buffer."""

    scalar: Scalar
    length: Expression | None

    @property
    def kind(self) -> str:
        """The letter of a unit."""
        return KINDS[self.scalar]

    @property
    def is_wide(self) -> bool:
        """Whether a unit is more than a byte."""
        return self.kind not in "bB"


Node: TypeAlias = Nothing | Basic | Octets | FixedArray | Record | Counted | String


@dataclass(frozen=True, slots=True)
class Item:
    """A parameter, a member or the return value (whose name is empty).

    `pointer` tells that the value is behind a pointer without sizes.
    """

    name: str
    node: Node
    span: Span
    pointer: bool = False
    nullable: bool = False
    direction: TecsDirection | None = None

    @property
    def inward(self) -> bool:
        """Whether the value travels with the request."""
        return self.direction is not None and self.direction.inward

    @property
    def outward(self) -> bool:
        """Whether the value travels with the reply."""
        return self.direction is not None and self.direction.outward

    @property
    def asked(self) -> bool:
        """Whether the request tells if the caller wants the value."""
        return self.nullable and self.direction is TecsDirection.OUT


class Role(Enum):
    """What a field of a run is."""

    SOP = auto()
    ID = auto()
    EOP = auto()
    FLAG = auto()
    LENGTH = auto()
    VALUE = auto()


@dataclass(frozen=True, slots=True)
class Field:
    """A part of a run; `item` is that of a flag, a length or a value."""

    role: Role
    item: Item | None = None

    @property
    def kinds(self) -> tuple[tuple[str, int], ...]:
        """Letters with how often they repeat."""
        match self.role:
            case Role.SOP | Role.ID | Role.EOP:
                return (("H", 1),)
            case Role.FLAG:
                return (("b", 1),)
            case Role.LENGTH:
                return (("i", 1),)
        assert self.item is not None
        return kinds(self.item.node)


@dataclass(frozen=True, slots=True)
class Run:
    """Fields of fixed size, one after the other."""

    fields: tuple[Field, ...]

    @property
    def kinds(self) -> tuple[tuple[str, int], ...]:
        """Letters with how often they repeat."""
        return tuple(kind for field in self.fields for kind in field.kinds)


@dataclass(frozen=True, slots=True)
class Payload:
    """The elements of a `Counted` whose elements have a fixed size, or the units of a `String`."""

    item: Item


@dataclass(frozen=True, slots=True)
class Part:
    """A value that is made of others whose sizes depend on values."""

    item: Item


@dataclass(frozen=True, slots=True)
class Branch:
    """Steps that are there only if the item is not NULL."""

    item: Item
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class Reserve:
    """No byte: the memory that an outward array or text will need in the server."""

    item: Item


Step: TypeAlias = Run | Payload | Part | Branch | Reserve


@dataclass(frozen=True, slots=True)
class FunctionLayout:
    """A function. `reply` is None where it is oneway; `paper` the reply with the outs first.

    `kept` are the parameters whose value in the request the reply depends on. `leaves_out`:
    after an `E_RPC` the reply has no outs.
    """

    function: TecsFunction
    items: tuple[Item, ...]
    returned: Item
    request: tuple[Step, ...]
    reply: tuple[Step, ...] | None
    paper: tuple[Step, ...] | None
    kept: tuple[Item, ...]
    leaves_out: bool

    @property
    def arguments(self) -> tuple[Item, ...]:
        """What the request tells something of."""
        return tuple(i for i in self.items if i.inward or i.asked)

    @property
    def outs(self) -> tuple[Item, ...]:
        """What the reply has values of."""
        return tuple(i for i in self.items if i.outward)

    @property
    def is_void(self) -> bool:
        """Whether nothing is returned."""
        return isinstance(self.returned.node, Nothing)


@dataclass(frozen=True, slots=True)
class SignatureLayout:
    """A signature; `records` are the structs it needs, those inside others first."""

    signature: Signature
    functions: tuple[FunctionLayout, ...]
    records: tuple[Record, ...]


def kinds(node: Node) -> tuple[tuple[str, int], ...]:
    """The letters of a node of fixed size with how often they repeat."""
    match node:
        case Basic():
            return (("16s" if node.kind in "wW" else node.kind, 1),)
        case Octets(count=count):
            return ((f"{count}s", 1),)
        case FixedArray(Basic() as basic, count) if basic.kind not in "wW":
            return ((f"{count}{basic.kind}", 1),)
        case FixedArray(element, count):
            inner = kinds(element)
            if len(inner) == 1 and inner[0][1] == 1:
                return ((inner[0][0], count),)
            return (("".join(text * times for text, times in inner), count),)
        case Record():
            fields = (f for s in node.steps if isinstance(s, Run) for f in s.fields)
            return tuple(kind for field in fields for kind in field.kinds)
        case Nothing():
            return ()
    raise AssertionError(node)


def is_fixed(node: Node) -> bool:
    """Whether the size of a value depends on no other value."""
    match node:
        case Record():
            return node.fixed
        case FixedArray(element):
            return is_fixed(element)
        case Counted() | String():
            return False
    return True


def references(expression: Expression | None) -> Iterator[str]:
    """The names of parameters or members in an expression, members of a struct's value aside."""
    match expression:
        case Reference(name):
            yield name
        case UnaryExpression(_, operand) | CastExpression(_, operand):
            yield from references(operand)
        case BinaryExpression(operator, left, right):
            yield from references(left)
            if operator != ".":
                yield from references(right)
        case ConditionalExpression(condition, yes, no):
            for part in (condition, yes, no):
                yield from references(part)
        case AggregateExpression(items):
            for part in items:
                yield from references(part)


def sizes_of(node: Node) -> tuple[Expression, ...]:
    """The expressions that the layout of a value depends on, `size` before `count`."""
    match node:
        case Counted(element, size, count):
            own = (size,) if count is size else (size, count)
            return own + sizes_of(element)
        case String(length=length) if length is not None:
            return (length,)
    return ()


def layout_of(unit: TecsUnit, signature: Signature) -> SignatureLayout:
    """The layout of all functions; raises TransferError."""
    nodes = _Nodes(unit)
    functions = tuple(_function(nodes, f) for f in signature.functions)
    return SignatureLayout(signature, functions, tuple(nodes.records.values()))


def problems(unit: TecsUnit, signature: Signature) -> Iterator[TransferError]:
    """What OpaqueRPC cannot carry, at most one finding for each function."""
    nodes = _Nodes(unit)
    for function in signature.functions:
        try:
            _function(nodes, function)
        except TransferError as found:
            yield found


def _function(nodes: _Nodes, function: TecsFunction) -> FunctionLayout:
    items = tuple(nodes.parameter(parameter) for parameter in function.parameters)
    returned = Item("", nodes.plain(function.returns, function.span), function.span)
    arguments = [i for i in items if i.inward]
    outs = [i for i in items if i.outward]
    for item in items:
        _check_names(item, {i.name for i in items}, function)
    inward = _in_order(arguments, items)
    _check_order(inward, (), (), function)
    asked = [Field(Role.FLAG, i) for i in items if i.asked]
    reserved = [Reserve(i) for i in items if _is_reserved(i, arguments)]
    request = _steps(
        [Field(Role.SOP), Field(Role.ID)],
        [step for item in inward for step in _value(item, flag=True)],
        [*asked, Field(Role.EOP), *reserved],
    )
    if function.oneway:
        return FunctionLayout(function, items, returned, request, None, None, (), False)
    outward = _in_order(outs, items)
    _check_order(outward, [i for i in arguments if not i.outward], arguments, function)
    values = [step for item in outward for step in _reply_value(item)]
    result = _value(returned, flag=False)
    begin, end = [Field(Role.SOP)], [Field(Role.EOP)]
    leaves_out = bool(outs) and _is_er(function.returns)
    return FunctionLayout(
        function,
        items,
        returned,
        request,
        _steps(begin, result, values, end),
        _steps(begin, values, result, end),
        tuple(i for i in items if _is_kept(i, outs, items)),
        leaves_out,
    )


def _is_er(type_: CType) -> bool:
    """Whether tecsgen takes the type for one of error codes: by its written name."""
    return isinstance(type_, CTypedefType) and type_.name in (("ER",), ("ER_INT",))


def _in_order(items: Sequence[Item], all_items: Iterable[Item]) -> list[Item]:
    """Referenced ones first, each group as declared."""
    names = {
        name
        for item in all_items
        for expression in sizes_of(item.node)
        for name in references(expression)
    }
    first = [item for item in items if item.name in names]
    return first + [item for item in items if item.name not in names]


def _check_names(item: Item, names: set[str], function: TecsFunction) -> None:
    for expression in sizes_of(item.node):
        _check_expression(expression, item)
        for name in references(expression):
            if name not in names:
                raise TransferError(
                    item.span, f"{name!r} is no parameter of {function.name!r}"
                )


def _check_expression(expression: Expression, item: Item) -> None:
    """Whether an expression can be worked out from values."""
    parts: tuple[Expression, ...] = ()
    match expression:
        case UnaryExpression(_, operand):
            parts = (operand,)
        case BinaryExpression(operator, left, right):
            parts = (left,) if operator == "." else (left, right)
        case ConditionalExpression(condition, yes, no):
            parts = (condition, yes, no)
        case CastExpression(type_, operand):
            scalar = resolve(type_)
            if not isinstance(scalar, CScalarType) or scalar.kind not in INTEGERS:
                raise TransferError(item.span, f"a cast to {type_} in a size")
            parts = (operand,)
        case Literal(int()) | Reference():
            pass
        case other:
            raise TransferError(item.span, f"{other} cannot be a size")
    for part in parts:
        _check_expression(part, item)


def _check_order(
    items: Sequence[Item],
    before: Sequence[Item],
    given: Sequence[Item],
    function: TecsFunction,
) -> None:
    """Whether each size is known when the value it belongs to is met.

    `before` came earlier, `given` are known to both ends from the request.
    """
    known = {item.name for item in before}
    travels = {item.name for item in items}
    for item in items:
        bounds = capacity(item.node) if is_known(item.node, given) else None
        for expression in sizes_of(item.node):
            for name in references(expression):
                if name in known or (expression is bounds and _is_bound_only(item)):
                    continue
                late = name in travels and name != item.name
                raise TransferError(
                    item.span,
                    f"the size of {item.name!r} depends on {name!r}, which comes "
                    + ("after it" if late else "another way"),
                    f"declare {name!r} before {item.name!r}" if late else None,
                )
        known.add(item.name)


def _is_bound_only(item: Item) -> bool:
    node = item.node
    return isinstance(node, Counted) and node.count is not node.size


def _is_reserved(item: Item, arguments: Sequence[Item]) -> bool:
    """Whether the server needs memory for an out before the call, and can know how much."""
    if item.direction is not TecsDirection.OUT:
        return False
    return capacity(item.node) is not None and is_known(item.node, arguments)


def capacity(node: Node) -> Expression | None:
    """The expression for how many elements or units the caller can hold."""
    match node:
        case Counted(size=size):
            return size
        case String(length=length):
            return length
    return None


def is_known(node: Node, items: Iterable[Item]) -> bool:
    """Whether the capacity follows from the values of these items."""
    names = {item.name for item in items}
    return all(name in names for name in references(capacity(node)))


def _is_kept(item: Item, outs: Sequence[Item], items: Sequence[Item]) -> bool:
    if item.outward and item.nullable:
        return item.direction is not TecsDirection.RECEIVE
    if not item.inward:
        return False
    arguments = [i for i in items if i.inward]
    for out in outs:
        used = {name for e in sizes_of(out.node) for name in references(e)}
        if item.name in used and not item.outward:
            return True
        bounds = capacity(out.node)
        if item.name in references(bounds) and is_known(out.node, arguments):
            return True
    return False


def _value(item: Item, flag: bool) -> list[Field | Step]:
    """The steps of a value, behind its flag if it is nullable."""
    if item.nullable and flag:
        body = _steps(_value(item, flag=False))
        return [Field(Role.FLAG, item), Branch(item, body)]
    match item.node:
        case Nothing():
            return []
        case String():
            return [Field(Role.LENGTH, item), Payload(item)]
        case Counted(element) if is_fixed(element):
            return [Payload(item)]
        case node if is_fixed(node):
            return [Field(Role.VALUE, item)]
    return [Part(item)]


def _reply_value(item: Item) -> list[Field | Step]:
    if item.nullable and item.direction is not TecsDirection.RECEIVE:
        return [Branch(item, _steps(_value(item, flag=False)))]
    return _value(item, flag=True)


def _steps(*parts: Sequence[Field | Step]) -> tuple[Step, ...]:
    """All parts, with fields that follow each other made into runs."""
    steps: list[Step] = []
    fields: list[Field] = []
    for part in parts:
        for step in part:
            if isinstance(step, Field):
                fields.append(step)
                continue
            if fields:
                steps.append(Run(tuple(fields)))
                fields = []
            steps.append(step)
    if fields:
        steps.append(Run(tuple(fields)))
    return tuple(steps)


class _Nodes:
    """Makes nodes of types."""

    def __init__(self, unit: TecsUnit) -> None:
        self._structs = {
            d.name: d for d in unit.declarations if isinstance(d, TecsStruct)
        }
        self._open: set[tuple[str, ...]] = set()
        self.records: dict[tuple[str, ...], Record] = {}

    def parameter(self, parameter: TecsParameter) -> Item:
        """The item of a parameter."""
        type_ = parameter.type
        if parameter.direction is TecsDirection.RECEIVE:
            inner = resolve(type_)
            type_ = inner.target if isinstance(inner, CPointerType) else inner
        sizes, direction = parameter.sizes, parameter.direction
        writable = direction in (TecsDirection.OUT, TecsDirection.INOUT)
        if writable and sizes.unsized_string:
            raise TransferError(
                parameter.span,
                f"the string {parameter.name!r} needs a length",
                "give the size of the buffer: string(n)",
            )
        if writable and sizes.count_is is not None and sizes.size_is is None:
            raise TransferError(
                parameter.span,
                f"{parameter.name!r} has count_is without size_is",
                "add size_is",
            )
        return Item(
            parameter.name,
            self._sized(type_, sizes, parameter.span),
            parameter.span,
            _is_plain_pointer(type_, sizes),
            sizes.nullable,
            parameter.direction,
        )

    def _sized(self, type_: CType, sizes: Sizes, span: Span) -> Node:
        size = sizes.count_is if sizes.size_is is None else sizes.size_is
        if size is None:
            return self._string(type_, sizes, span)
        target = _target(type_, span)
        element = self._string(target, sizes, span)
        if isinstance(element, Nothing):
            raise TransferError(span, "an array of void")
        count = size if sizes.count_is is None else sizes.count_is
        return Counted(element, size, count, sizes.max_size)

    def _string(self, type_: CType, sizes: Sizes, span: Span) -> Node:
        if not sizes.is_string:
            return self.plain(type_, span)
        unit = resolve(_target(type_, span))
        if isinstance(unit, CScalarType) and KINDS.get(unit.kind, "-") in _TEXT_UNITS:
            return String(unit.kind, sizes.string)
        raise TransferError(
            span,
            f"a string of {unit}",
            "a string has elements of char_t, int8_t to int64_t or uint8_t to uint64_t",
        )

    def plain(self, type_: CType, span: Span) -> Node:
        """The node of a type without sizes; pointers stand for what they point to."""
        match resolve(type_):
            case CPointerType(target):
                return self.plain(target, span)
            case CScalarType(Scalar.VOID):
                return Nothing()
            case CScalarType(kind):
                return Basic(kind)
            case CStructType(tag):
                return self._record(tag, span)
            case CArrayType(size=None):
                raise TransferError(span, "an array without a size")
            case CArrayType(element, int(size)):
                inner = self.plain(element, span)
                if isinstance(inner, Basic) and inner.scalar in _OCTETS:
                    return Octets(inner.scalar, size)
                return FixedArray(inner, size)
            case CEnumType() as enum:
                raise TransferError(
                    span, f"{enum} cannot be transferred", "use an integer type"
                )
            case other:
                raise TransferError(span, f"{other} cannot be transferred")

    def _record(self, tag: tuple[str, ...], span: Span) -> Record:
        if tag in self.records:
            return self.records[tag]
        scoped = "::".join(tag)
        if tag in self._open:
            raise TransferError(span, f"struct {scoped} contains itself")
        if tag not in self._structs:
            raise TransferError(span, f"struct {scoped} is declared without members")
        struct = self._structs[tag]
        self._open.add(tag)
        items = tuple(
            Item(
                member.name,
                self._sized(member.type, member.sizes, member.span),
                member.span,
                _is_plain_pointer(member.type, member.sizes),
            )
            for member in struct.members
        )
        self._open.discard(tag)
        ordered = _in_order(items, items)
        _check_members(struct, ordered)
        steps = _steps([s for item in ordered for s in _value(item, flag=False)])
        self.records[tag] = Record(struct, items, steps)
        return self.records[tag]


def _check_members(struct: TecsStruct, ordered: Sequence[Item]) -> None:
    known: set[str] = set()
    for item in ordered:
        for expression in sizes_of(item.node):
            _check_expression(expression, item)
            for name in references(expression):
                if name not in known:
                    raise TransferError(
                        item.span,
                        f"the size of {struct.scoped}.{item.name} depends on {name!r}, "
                        "which does not come before it",
                    )
        known.add(item.name)


def _target(type_: CType, span: Span) -> CType:
    pointer = resolve(type_)
    if not isinstance(pointer, CPointerType):
        raise TransferError(span, f"{type_} is no pointer")
    return pointer.target


def _is_plain_pointer(type_: CType, sizes: Sizes) -> bool:
    if sizes.size_is is not None or sizes.count_is is not None or sizes.is_string:
        return False
    return isinstance(resolve(type_), CPointerType)
