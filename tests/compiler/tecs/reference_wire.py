"""An independent OpaqueRPC implementation, scalar by scalar, by `opaque-rpc-wire`."""

from __future__ import annotations

import struct
from typing import Any

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
    Sizes,
    TecsDirection,
    TecsFunction,
    TecsStruct,
    TecsUnit,
)
from rtgen.facts.tdr import Scalar

WIDTHS = {
    Scalar.BOOL: 1,
    Scalar.CHAR: 1,
    Scalar.SCHAR: 1,
    Scalar.UCHAR: 1,
    Scalar.SHORT: 2,
    Scalar.USHORT: 2,
    Scalar.INT: 4,
    Scalar.UINT: 4,
    Scalar.LONG_LONG: 8,
    Scalar.ULONG_LONG: 8,
}
LONGS = (Scalar.LONG, Scalar.ULONG, Scalar.INTPTR, Scalar.UINTPTR)


class Wire:
    """Writes messages; `order` is network, little or big."""

    def __init__(self, unit: TecsUnit, order: str) -> None:
        self._structs = {
            d.name: d for d in unit.declarations if isinstance(d, TecsStruct)
        }
        self._order = order
        self._end = "little" if order == "little" else "big"
        self._out = bytearray()

    def request(self, function: TecsFunction, args: dict[str, Any]) -> bytes:
        self._out = bytearray()
        self._magic(0x672A)
        self._magic(function.id)
        inward = [p for p in function.parameters if p.direction.inward]
        for parameter in self._passes(function, inward):
            value = args[parameter.name]
            if parameter.sizes.nullable:
                self._out.append(1 if value is None else 0)
            if not parameter.sizes.nullable or value is not None:
                self._sized(parameter.type, parameter.sizes, value, args)
        for parameter in function.parameters:
            if parameter.sizes.nullable and parameter.direction is TecsDirection.OUT:
                self._out.append(0 if args[parameter.name] else 1)
        self._magic(0x6D5E if function.oneway else 0x5A3C)
        return bytes(self._out)

    def reply(
        self,
        function: TecsFunction,
        args: dict[str, Any],
        returned: Any,
        outs: dict[str, Any],
        paper: bool = False,
    ) -> bytes:
        self._out = bytearray()
        self._magic(0x561E)
        if not paper:
            self._sized(function.returns, Sizes(), returned, {})
        is_er = isinstance(function.returns, CTypedefType)
        if paper or not (is_er and returned & 0xFF == 0xBC):
            self._outs(function, args, outs)
        if paper:
            self._sized(function.returns, Sizes(), returned, {})
        self._magic(0x6D5E)
        return bytes(self._out)

    def _outs(
        self, function: TecsFunction, args: dict[str, Any], outs: dict[str, Any]
    ) -> None:
        outward = [p for p in function.parameters if p.direction.outward]
        for parameter in self._passes(function, outward):
            value, type_ = outs[parameter.name], parameter.type
            if parameter.direction is TecsDirection.RECEIVE:
                pointer = resolve(type_)
                assert isinstance(pointer, CPointerType)
                type_ = pointer.target
                if parameter.sizes.nullable:
                    self._out.append(1 if value is None else 0)
                    if value is None:
                        continue
            elif parameter.sizes.nullable:
                given = args[parameter.name]
                # An out is sent as whether there is room; an inout may be a false bool.
                is_out = parameter.direction is TecsDirection.OUT
                if given is None or (is_out and not given):
                    continue
            self._sized(type_, parameter.sizes, value, {**args, **outs})

    def _passes(self, function: TecsFunction, parameters: list[Any]) -> list[Any]:
        names = {
            name
            for p in function.parameters
            for e in (p.sizes.size_is, p.sizes.count_is, p.sizes.string)
            for name in _names(e)
        }
        return [p for p in parameters if p.name in names] + [
            p for p in parameters if p.name not in names
        ]

    def _sized(
        self, type_: CType, sizes: Sizes, value: Any, names: dict[str, Any]
    ) -> None:
        if sizes.size_is is not None:
            pointer = resolve(type_)
            assert isinstance(pointer, CPointerType)
            count = _worked_out(sizes.count_is or sizes.size_is, names)
            values = list(value)
            for index in range(count):
                inner = Sizes(string=sizes.string, unsized_string=sizes.unsized_string)
                self._sized(pointer.target, inner, values[index], names)
        elif sizes.is_string:
            self._text(type_, sizes.string, value, names)
        else:
            self._plain(type_, value)

    def _text(
        self,
        type_: CType,
        length: Expression | None,
        value: Any,
        names: dict[str, Any],
    ) -> None:
        pointer = resolve(type_)
        assert isinstance(pointer, CPointerType)
        unit = resolve(pointer.target)
        assert isinstance(unit, CScalarType)
        units = [ord(c) for c in value] if isinstance(value, str) else list(value)
        units = [u - 256 if unit.kind is Scalar.INT8 and u > 127 else u for u in units]
        units += [0, 0]
        if length is None:
            n = len(value) + 1
        else:
            size = _worked_out(length, names)
            reached = min(len(value), size - 1) + 1  # strnlen(s, e - 1) + 1
            n = reached if reached == size else reached + 1
        self._number(Scalar.INT32, n)
        for each in units[:n]:
            self._number(unit.kind, each)

    def _plain(self, type_: CType, value: Any) -> None:
        match resolve(type_):
            case CPointerType(target):
                self._plain(target, value)
            case CScalarType(Scalar.VOID):
                return
            case CScalarType(kind):
                self._number(kind, value)
            case CArrayType(element, int(size)):
                for index in range(size):
                    self._plain(element, value[index])
            case CStructType(tag):
                self._struct(self._structs[tag], value)

    def _struct(self, declaration: TecsStruct, value: Any) -> None:
        names = {m.name: getattr(value, m.name) for m in declaration.members}
        used = {
            name
            for m in declaration.members
            for e in (m.sizes.size_is, m.sizes.count_is, m.sizes.string)
            for name in _names(e)
        }
        members = [m for m in declaration.members if m.name in used]
        members += [m for m in declaration.members if m.name not in used]
        for member in members:
            self._sized(member.type, member.sizes, names[member.name], names)

    def _number(self, kind: Scalar, value: Any) -> None:
        if kind in (Scalar.FLOAT32, Scalar.DOUBLE64):
            letter = "f" if kind is Scalar.FLOAT32 else "d"
            sign = "<" if self._end == "little" else ">"
            self._out += struct.pack(sign + letter, value)
            return
        width = self._width(kind)
        data = (int(value) & ((1 << 8 * width) - 1)).to_bytes(width, "big")
        if width == 16 and self._order == "network":
            data = data[8:] + data[:8]
        self._out += data if self._end == "big" else data[::-1]

    def _width(self, kind: Scalar) -> int:
        if kind in LONGS:
            return 4 if self._order == "network" else 8
        if kind in WIDTHS:
            return WIDTHS[kind]
        return int("".join(filter(str.isdigit, kind.value))) // 8

    def _magic(self, value: int) -> None:
        data = bytes((value >> 8, value & 0xFF))
        self._out += data if self._end == "big" else data[::-1]


def _names(expression: Expression | None) -> list[str]:
    match expression:
        case Reference(name):
            return [name]
        case UnaryExpression(_, operand):
            return _names(operand)
        case BinaryExpression(_, left, right):
            return _names(left) + _names(right)
    return []


def _worked_out(expression: Expression, names: dict[str, Any]) -> int:
    match expression:
        case Literal(value):
            return int(value)
        case Reference(name) | UnaryExpression("*", Reference(name)):
            return int(names[name])
        case BinaryExpression(operator, left, right):
            a, b = _worked_out(left, names), _worked_out(right, names)
            return {"+": a + b, "*": a * b, "/": a // b if b else 0}[operator]
    raise AssertionError(expression)
