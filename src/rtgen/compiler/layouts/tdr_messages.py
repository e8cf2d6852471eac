"""Messages of TECS functions: steps in wire order, and request values kept for the reply."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.kit.limits import MAX_LEVELS, MAX_VALUES
from rtgen.compiler.layouts.tdr import (
    OCTETS,
    Basic,
    Branch,
    Counted,
    Field,
    FixedArray,
    FunctionLayout,
    Item,
    Node,
    Nothing,
    Octets,
    Part,
    Payload,
    Record,
    Reserve,
    Role,
    Run,
    SignatureLayout,
    Step,
    String,
    TransferError,
    capacity,
    is_fixed,
    is_known,
    kinds,
    references,
    sizes_of,
)
from rtgen.compiler.model.c_types import (
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
    UnaryExpression,
    resolve,
)
from rtgen.compiler.model.tecs import (
    Signature,
    Sizes,
    TecsDirection,
    TecsFunction,
    TecsParameter,
    TecsStruct,
    TecsUnit,
)
from rtgen.facts.tdr import INTEGERS, LETTERS, Scalar

_TEXT_UNITS = frozenset("bBhHiIqQ")


def layout_of(unit: TecsUnit, signature: Signature) -> SignatureLayout:
    """Return the layout of all functions. Raises TransferError."""
    nodes = _Nodes(unit)
    functions = tuple(_function(nodes, f) for f in signature.functions)
    return SignatureLayout(signature, functions, tuple(nodes.records.values()))


def problems(unit: TecsUnit, signature: Signature) -> Iterator[TransferError]:
    """Yield the functions that OpaqueRPC cannot transfer, with at most one problem each."""
    nodes = _Nodes(unit)
    for function in signature.functions:
        try:
            _function(nodes, function)
        except TransferError as found:
            yield found


def read_too_early(layout: SignatureLayout) -> Iterator[tuple[Item, str]]:
    """Yield outs whose number a server of tecsgen reads before the call, with that parameter.

    For each out with `count_is`, it allocates as many elements as that has then; another out has
    no value yet, and no memory.
    """
    for function in layout.functions:
        outs = [i for i in function.items if i.direction is TecsDirection.OUT]
        names = {item.name for item in outs}
        for item in filter(_is_bound_only, outs):
            assert isinstance(item.node, Counted)
            for name in sorted(names.intersection(references(item.node.count))):
                yield item, name


def _function(nodes: _Nodes, function: TecsFunction) -> FunctionLayout:
    items = tuple(nodes.parameter(parameter) for parameter in function.parameters)
    returned = Item("", nodes.plain(function.returns, function.span), function.span)
    arguments = [i for i in items if i.inward]
    outs = [i for i in items if i.outward]
    for item in items:
        _check_names(item, {i.name for i in items}, function)
    inward = _in_order(arguments, items)
    _check_order(inward, (), ())
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
    _check_order(outward, [i for i in arguments if not i.outward], arguments)
    values = [step for item in outward for step in _reply_value(item)]
    result = _value(returned, flag=False)
    begin, end = [Field(Role.SOP)], [Field(Role.EOP)]
    leaves_out = bool(outs) and is_error_code(function.returns)
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


def is_error_code(type_: CType) -> bool:
    """Return whether tecsgen treats the type as an error code, by its name as written."""
    return isinstance(type_, CTypedefType) and type_.name in (("ER",), ("ER_INT",))


def _in_order(items: Sequence[Item], all_items: Iterable[Item]) -> list[Item]:
    """Return referenced items first, each group in order of declaration."""
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
                    item.span, f"{name!r} is not a parameter of {function.name!r}"
                )


def _check_expression(expression: Expression, item: Item) -> None:
    """Check that an expression can be computed from values."""
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
    known_items: Sequence[Item],
) -> None:
    """Check that each size is known before the value that depends on it.

    `before` are earlier values, `known_items` those that both peers know from the request.
    """
    names = {item.name for item in before}
    travels = {item.name for item in items}
    for item in items:
        bounds = capacity(item.node) if is_known(item.node, known_items) else None
        for expression in sizes_of(item.node):
            for name in references(expression):
                if name in names or (expression is bounds and _is_bound_only(item)):
                    continue
                late = name in travels and name != item.name
                raise TransferError(
                    item.span,
                    f"the size of {item.name!r} depends on {name!r}, which comes "
                    + ("after it" if late else "another way"),
                    f"declare {name!r} before {item.name!r}" if late else None,
                )
        names.add(item.name)


def _is_bound_only(item: Item) -> bool:
    node = item.node
    return isinstance(node, Counted) and node.count is not node.size


def _is_reserved(item: Item, arguments: Sequence[Item]) -> bool:
    """Return whether the server can and must allocate an out's memory before the call.

    It must for an outward array or string, and can if its size is known.
    """
    if item.direction is not TecsDirection.OUT:
        return False
    return capacity(item.node) is not None and is_known(item.node, arguments)


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
    """Return the steps of a value, after its flag if it is nullable."""
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
    """Return all steps, with consecutive fields merged into runs."""
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
        self._structs = unit.structs
        self._open: set[tuple[str, ...]] = set()
        self._counts: dict[tuple[str, ...], int] = {}
        self.records: dict[tuple[str, ...], Record] = {}

    def parameter(self, parameter: TecsParameter) -> Item:
        """Return the item of a parameter."""
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
        _check_element(element, span)
        count = size if sizes.count_is is None else sizes.count_is
        return Counted(element, size, count, sizes.max_size)

    def _string(self, type_: CType, sizes: Sizes, span: Span) -> Node:
        if not sizes.is_string:
            return self.plain(type_, span)
        unit = resolve(_target(type_, span))
        if isinstance(unit, CScalarType) and LETTERS.get(unit.kind, "-") in _TEXT_UNITS:
            return String(unit.kind, sizes.string)
        raise TransferError(
            span,
            f"a string of {unit}",
            "a string has elements of char_t, int8_t to int64_t or uint8_t to uint64_t",
        )

    def plain(self, type_: CType, span: Span) -> Node:
        """Return the node of a type without sizes; a pointer has the node of its target."""
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
                if isinstance(inner, Basic) and inner.scalar in OCTETS:
                    return Octets(inner.scalar, size)
                _check_element(inner, span)
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
        if len(self._open) == MAX_LEVELS:
            reason = f"structs that hold each other for more than {MAX_LEVELS} levels"
            raise TransferError(span, reason)
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
        values = sum(self._values(item.node) for item in items)
        if values > MAX_VALUES:
            reason = f"struct {scoped} has more than {MAX_VALUES:,} values in place"
            hint = "put less into it, or a size_is array in place of a long one"
            raise TransferError(span, reason, hint)
        self._counts[tag] = values
        self.records[tag] = Record(struct, items, steps)
        return self.records[tag]

    def _values(self, node: Node) -> int:
        """Return the number of values with a position of their own in messages with the node."""
        match node:
            case Record(struct):
                return self._counts[struct.name]
            case FixedArray(element, count) if not isinstance(element, Basic):
                return count * self._values(element)
        return 1


def _check_members(struct: TecsStruct, ordered: Sequence[Item]) -> None:
    names: set[str] = set()
    for item in ordered:
        for expression in sizes_of(item.node):
            _check_expression(expression, item)
            for name in references(expression):
                if name not in names:
                    raise TransferError(
                        item.span,
                        f"the size of {struct.scoped}.{item.name} depends on {name!r}, "
                        "which does not come before it",
                    )
        names.add(item.name)


def _check_element(element: Node, span: Span) -> None:
    """Reject elements without bytes, since a message could claim any number of them."""
    if is_fixed(element) and not kinds(element):
        raise TransferError(span, "an array of elements that have no byte")


def _target(type_: CType, span: Span) -> CType:
    pointer = resolve(type_)
    if not isinstance(pointer, CPointerType):
        raise TransferError(span, f"{type_} is not a pointer")
    return pointer.target


def _is_plain_pointer(type_: CType, sizes: Sizes) -> bool:
    if sizes.size_is is not None or sizes.count_is is not None or sizes.is_string:
        return False
    return isinstance(resolve(type_), CPointerType)
