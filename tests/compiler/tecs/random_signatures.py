"""Random signatures of TECS with matching random values: all types, directions, sizes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from types import ModuleType
from typing import Any

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.c_types import (
    BinaryExpression,
    CArrayType,
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
    TecsMember,
    TecsParameter,
    TecsStruct,
    TecsUnit,
)
from rtgen.facts.tdr import Scalar

SPAN = Span("random.cdl", 1, 1, 1, 2)
IN, OUT, INOUT = TecsDirection.IN, TecsDirection.OUT, TecsDirection.INOUT
SEND, RECEIVE = TecsDirection.SEND, TecsDirection.RECEIVE

SCALARS = [scalar for scalar in Scalar if scalar is not Scalar.VOID]
UNITS = [
    Scalar.CHAR,
    Scalar.UINT8,
    Scalar.INT8,
    Scalar.INT16,
    Scalar.UINT16,
    Scalar.INT32,
    Scalar.UINT32,
    Scalar.INT64,
    Scalar.UINT64,
]
OCTETS = (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR, Scalar.UINT8)
TEXT_OCTETS = (*OCTETS, Scalar.INT8)
FLOATS = (Scalar.FLOAT32, Scalar.DOUBLE64)
ER = CTypedefType(("ER",), CScalarType(Scalar.INT))


def scalar(kind: Scalar) -> CScalarType:
    return CScalarType(kind)


def pointer(type_: CType) -> CPointerType:
    return CPointerType(type_)


def _struct(tag: str, *members: tuple[str, CType, Sizes]) -> TecsStruct:
    return TecsStruct(
        name=(tag,),
        file="random.cdl",
        span=SPAN,
        members=tuple(
            TecsMember(name=name, type=type_, sizes=sizes, span=SPAN)
            for name, type_, sizes in members
        ),
    )


_PLAIN = Sizes()
STRUCTS = (
    _struct(
        "tagPoint",
        ("x", scalar(Scalar.INT16), _PLAIN),
        ("y", scalar(Scalar.INT32), _PLAIN),
    ),
    _struct(
        "tagShape",
        ("a", CStructType(("tagPoint",)), _PLAIN),
        ("tag", CArrayType(scalar(Scalar.UINT8), 3), _PLAIN),
        ("corner", CArrayType(CStructType(("tagPoint",)), 2), _PLAIN),
        ("grid", CArrayType(CArrayType(scalar(Scalar.INT8), 3), 2), _PLAIN),
        ("huge", CArrayType(scalar(Scalar.UINT128), 2), _PLAIN),
        ("on", scalar(Scalar.BOOL), _PLAIN),
        ("at", pointer(scalar(Scalar.LONG)), _PLAIN),
    ),
    _struct(
        "tagBlob",
        ("kind", scalar(Scalar.CHAR), _PLAIN),
        ("data", pointer(scalar(Scalar.UINT8)), Sizes(size_is=Reference("len"))),
        ("len", scalar(Scalar.INT32), _PLAIN),
    ),
    _struct(
        "tagNote",
        ("id", scalar(Scalar.INT16), _PLAIN),
        ("text", pointer(scalar(Scalar.CHAR)), Sizes(unsized_string=True)),
        ("val", pointer(scalar(Scalar.DOUBLE64)), _PLAIN),
        ("nick", pointer(scalar(Scalar.CHAR)), Sizes(string=Literal(8))),
        ("wide", pointer(scalar(Scalar.UINT16)), Sizes(string=Literal(6))),
        ("blob", CArrayType(CStructType(("tagBlob",)), 2), _PLAIN),
    ),
    _struct(
        "tagList",
        ("last", CStructType(("tagNote",)), _PLAIN),
        (
            "points",
            pointer(CStructType(("tagPoint",))),
            Sizes(size_is=Reference("room"), count_is=Reference("used")),
        ),
        ("used", scalar(Scalar.UINT16), _PLAIN),
        ("notes", pointer(CStructType(("tagNote",))), Sizes(size_is=Reference("many"))),
        ("many", scalar(Scalar.INT8), _PLAIN),
        ("room", scalar(Scalar.UINT16), _PLAIN),
    ),
)
_BY_TAG = {declaration.name: declaration for declaration in STRUCTS}


@dataclass
class Call:
    """Values of a call by name; `want` for nullable outs, None for NULL."""

    args: dict[str, Any] = field(default_factory=dict)
    outs: dict[str, Any] = field(default_factory=dict)
    returned: Any = None


@dataclass
class Group:
    """Parameters that belong together, and the function that sets their values."""

    parameters: list[TecsParameter]
    fill: Callable[[Random, Call, ModuleType], None]


def ranges(kind: Scalar, long_bits: int = 32) -> tuple[int, int]:
    """Return the least and the greatest value."""
    widths = {
        Scalar.CHAR: (8, False),
        Scalar.SCHAR: (8, True),
        Scalar.UCHAR: (8, False),
        Scalar.SHORT: (16, True),
        Scalar.USHORT: (16, False),
        Scalar.INT: (32, True),
        Scalar.UINT: (32, False),
        Scalar.LONG: (long_bits, True),
        Scalar.ULONG: (long_bits, False),
        Scalar.INTPTR: (long_bits, True),
        Scalar.UINTPTR: (long_bits, False),
        Scalar.LONG_LONG: (64, True),
        Scalar.ULONG_LONG: (64, False),
    }
    if kind in widths:
        bits, signed = widths[kind]
    else:
        digits = "".join(filter(str.isdigit, kind.value))
        bits, signed = int(digits), not kind.value.startswith("u")
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)


def number(random: Random, kind: Scalar) -> Any:
    """Return a value of a basic type, often an extreme one."""
    if kind is Scalar.BOOL:
        return random.random() < 0.5
    if kind in FLOATS:
        value = random.choice([0.0, -1.5, 1e30, float("inf"), random.uniform(-9, 9)])
        if kind is Scalar.FLOAT32:
            return struct.unpack("f", struct.pack("f", value))[0]
        return value
    low, high = ranges(kind)
    return random.choice([low, high, 0, 1, random.randint(low, high)])


def text(random: Random, kind: Scalar, length: int) -> Any:
    """Return a text of `length` units."""
    if kind in TEXT_OCTETS:
        return "".join(chr(random.randint(1, 255)) for _ in range(length))
    low, high = ranges(kind)
    return [random.choice([low or 1, high, 1, 0x3042]) for _ in range(length)]


def value(random: Random, type_: CType, types: ModuleType) -> Any:
    """Return a value of a type without sizes."""
    match resolve(type_):
        case CPointerType(target):
            return value(random, target, types)
        case CScalarType(Scalar.VOID):
            return None
        case CScalarType(kind):
            return number(random, kind)
        case CArrayType(element, int(size)):
            inner = resolve(element)
            if isinstance(inner, CScalarType) and inner.kind in OCTETS:
                return random.randbytes(size)
            return [value(random, element, types) for _ in range(size)]
        case CStructType(tag):
            return struct_value(random, tag, types)
    raise AssertionError(type_)


def array(random: Random, element: CType, count: int, types: ModuleType) -> Any:
    """Return an array behind a pointer."""
    inner = resolve(element)
    if isinstance(inner, CScalarType) and inner.kind in OCTETS:
        return random.randbytes(count)
    return [value(random, element, types) for _ in range(count)]


def struct_value(random: Random, tag: tuple[str, ...], types: ModuleType) -> Any:
    """Return a struct whose lengths are right."""
    found = {}
    for member in _BY_TAG[tag].members:
        sizes, target = member.sizes, resolve(member.type)
        if isinstance(target, CPointerType) and sizes.is_string:
            unit = resolve(target.target)
            assert isinstance(unit, CScalarType)
            most = 9 if sizes.string is None else int(str(sizes.string))
            found[member.name] = text(random, unit.kind, random.randint(0, most))
        elif isinstance(target, CPointerType) and sizes.size_is is not None:
            count = random.randint(0, 3)
            found[member.name] = array(random, target.target, count, types)
            found[str(sizes.count_is or sizes.size_is)] = count
            if sizes.count_is is not None:
                found[str(sizes.size_is)] = count + random.randint(0, 2)
        elif member.name not in found:
            found[member.name] = value(random, member.type, types)
    sized = {
        str(size)
        for m in _BY_TAG[tag].members
        for size in (m.sizes.size_is, m.sizes.count_is)
        if size is not None
    }
    assert sized <= set(found)
    return getattr(types, tag[0])(*(found[m.name] for m in _BY_TAG[tag].members))


class Signatures:
    """Generates functions with random parameters."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._names = 0

    def name(self, prefix: str) -> str:
        """Return an unused name, sometimes a keyword of Python."""
        self._names += 1
        if self._random.random() < 0.05:
            return f"{prefix}{self._names}"
        odd = ("more", "lambda", "len", "first", "None", "self", "budget", "class")
        if self._names <= len(odd):
            return odd[self._names - 1]
        return f"{prefix}{self._names}"

    def type(self) -> CType:
        """Return a basic type or a struct."""
        if self._random.random() < 0.25:
            return CStructType(self._random.choice(STRUCTS).name)
        return scalar(self._random.choice(SCALARS))

    def group(self) -> Group:
        """Return a random group."""
        often = [self.by_pointer, self.string, self.sized, self.sized]
        make = self._random.choice([self.by_value, self.void, *often])
        return make()

    def by_value(self) -> Group:
        type_ = self.type()
        if self._random.random() < 0.3:
            type_ = CArrayType(CArrayType(type_, 2), self._random.randint(1, 3))
        name = self.name("v")

        def fill(random: Random, call: Call, types: ModuleType) -> None:
            call.args[name] = value(random, type_, types)

        return Group([_parameter(name, type_, IN)], fill)

    def by_pointer(self) -> Group:
        target = self.type()
        direction = self._random.choice(list(TecsDirection))
        nullable = self._random.random() < 0.4
        name = self.name("p")
        type_ = pointer(target)
        if direction is RECEIVE:
            type_ = pointer(type_)

        def fill(random: Random, call: Call, types: ModuleType) -> None:
            _fill(
                random,
                call,
                name,
                direction,
                nullable,
                lambda: value(random, target, types),
            )

        sizes = Sizes(nullable=nullable)
        return Group([_parameter(name, type_, direction, sizes)], fill)

    def void(self) -> Group:
        name = self.name("u")

        def fill(random: Random, call: Call, types: ModuleType) -> None:
            call.args[name] = None

        return Group([_parameter(name, pointer(scalar(Scalar.VOID)), IN)], fill)

    def _size(
        self, direction: TecsDirection
    ) -> tuple[list[TecsParameter], Expression, Callable[[Call, Random], int]]:
        """Return parameters of a size, the size, and the function that sets it in a call."""
        random = self._random
        name = self.name("n")
        kind = random.choice([Scalar.INT32, Scalar.UINT8, Scalar.INT16, Scalar.LONG])
        if direction is RECEIVE:

            def of_out(call: Call, random: Random) -> int:
                call.outs[name] = count = random.randint(0, 4)
                return count

            parameter = _parameter(name, pointer(scalar(kind)), OUT)
            return [parameter], UnaryExpression("*", Reference(name)), of_out
        if random.random() < 0.25:
            constant = random.randint(1, 4)
            return [], Literal(constant), lambda call, random: constant
        forms: list[tuple[Expression, Callable[[int], int]]] = [
            (Reference(name), lambda n: n),
            (BinaryExpression("+", Reference(name), Literal(1)), lambda n: n + 1),
            (BinaryExpression("/", Reference(name), Literal(2)), lambda n: n // 2),
            (BinaryExpression("*", Literal(2), Reference(name)), lambda n: 2 * n),
        ]
        expression, work_out = random.choice(forms)

        def of_in(call: Call, random: Random) -> int:
            call.args[name] = count = random.randint(1, 4)
            return work_out(count)

        return [_parameter(name, scalar(kind), IN)], expression, of_in

    def sized(self) -> Group:
        random = self._random
        direction = random.choice(list(TecsDirection))
        name = self.name("a")
        parameters, size, fix = self._size(direction)
        as_text = direction in (IN, OUT) and random.random() < 0.2
        kind = random.choice(UNITS)
        element = pointer(scalar(kind)) if as_text else self.type()
        count: Expression | None = None
        counter = ""
        if direction in (IN, OUT, INOUT) and random.random() < 0.4:
            counter = self.name("c")
            count = (
                Reference(counter)
                if direction is IN
                else UnaryExpression("*", Reference(counter))
            )
            type_ = (
                scalar(Scalar.UINT16)
                if direction is IN
                else pointer(scalar(Scalar.UINT16))
            )
            parameters.append(_parameter(counter, type_, direction))
        most = 40 if random.random() < 0.3 else None
        length = Literal(5) if as_text else None
        sizes = Sizes(size_is=size, count_is=count, max_size=most, string=length)
        type_ = pointer(element)
        if direction is RECEIVE:
            type_ = pointer(type_)

        def fill(random: Random, call: Call, types: ModuleType) -> None:
            room = fix(call, random)

            def made(values: dict[str, Any]) -> Any:
                n = room
                if counter:
                    values[counter] = n = random.randint(0, room)
                if as_text:
                    return [text(random, kind, random.randint(0, 5)) for _ in range(n)]
                return array(random, element, n, types)

            if direction.inward:
                call.args[name] = made(call.args)
            if direction.outward:
                call.outs[name] = made(call.outs)

        random.shuffle(parameters)
        at = random.randint(0, len(parameters))
        parameters.insert(at, _parameter(name, type_, direction, sizes))
        return Group(parameters, fill)

    def string(self) -> Group:
        random = self._random
        direction = random.choice(list(TecsDirection))
        name, kind = self.name("s"), random.choice(UNITS)
        parameters: list[TecsParameter] = []
        sizes = Sizes(unsized_string=True, nullable=random.random() < 0.3)
        fix: Callable[[Call, Random], int] = lambda call, random: 9  # noqa: E731
        if direction in (OUT, INOUT) or random.random() < 0.5:
            parameters, length, fix = self._size(direction)
            sizes = Sizes(string=length, nullable=sizes.nullable)
        type_ = pointer(scalar(kind))
        if direction is RECEIVE:
            type_ = pointer(type_)

        def fill(random: Random, call: Call, types: ModuleType) -> None:
            room = fix(call, random)
            _fill(
                random,
                call,
                name,
                direction,
                sizes.nullable,
                lambda: text(random, kind, random.randint(0, room)),
            )

        parameters.insert(
            random.randint(0, len(parameters)),
            _parameter(name, type_, direction, sizes),
        )
        return Group(parameters, fill)

    def function(self, number: int) -> tuple[TecsFunction, list[Group], CType]:
        """Return a function with an id."""
        random = self._random
        groups = [self.group() for _ in range(random.randint(0, 4))]
        returns: CType = random.choice(
            [ER, ER, scalar(Scalar.VOID), scalar(Scalar.INT32), self.type()]
        )
        oneway = random.random() < 0.2
        if oneway:
            groups = [
                g
                for g in groups
                if all(p.direction in (IN, SEND) for p in g.parameters)
            ]
            returns = random.choice([ER, scalar(Scalar.VOID)])
        function = TecsFunction(
            id=number,
            name=f"f{number}",
            returns=returns,
            parameters=tuple(p for group in groups for p in group.parameters),
            oneway=oneway,
            span=SPAN,
        )
        return function, groups, returns


def _fill(
    random: Random,
    call: Call,
    name: str,
    direction: TecsDirection,
    nullable: bool,
    made: Callable[[], Any],
) -> None:
    null = nullable and random.random() < 0.4
    if direction.inward:
        call.args[name] = None if null else made()
    elif nullable and direction is OUT:
        call.args[name] = not null
    if direction.outward:
        call.outs[name] = None if null else made()


def _parameter(
    name: str, type_: CType, direction: TecsDirection, sizes: Sizes = _PLAIN
) -> TecsParameter:
    return TecsParameter(
        name=name, type=type_, direction=direction, sizes=sizes, span=SPAN
    )


@dataclass
class Sample:
    """A unit with one signature, and the maker of calls of each function."""

    unit: TecsUnit
    signature: Signature
    groups: dict[str, list[Group]]

    def call(self, random: Random, function: TecsFunction, types: ModuleType) -> Call:
        """Return values of a call."""
        call = Call()
        for group in self.groups[function.name]:
            group.fill(random, call, types)
        if not function.oneway:
            call.returned = value(random, function.returns, types)
        return call


def sample(random: Random, functions: int = 3) -> Sample:
    """Return a random signature."""
    maker = Signatures(random)
    made = []
    for number in range(1, functions + 1):
        maker._names = 0
        made.append(maker.function(number))
    signature = Signature(
        name=("sRandom",),
        file="random.cdl",
        span=SPAN,
        functions=tuple(function for function, _, _ in made),
    )
    unit = TecsUnit("random.cdl", "random.cdl", (*STRUCTS, signature))
    return Sample(unit, signature, {f.name: groups for f, groups, _ in made})


def plain(value: Any) -> Any:
    """Return a value with structs as tuples: both ends have classes of their own."""
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    slots = getattr(type(value), "__slots__", None)
    if slots is not None and not isinstance(value, int | float | str | bytes):
        return [plain(getattr(value, name)) for name in slots]
    return value
