"""Compares C types of CDL: whether TDR transfers them in the same octets (tecsgen, OpaqueRPC)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rtgen.compiler.layouts.tdr import OCTETS
from rtgen.compiler.layouts.tdr_messages import is_error_code
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
    Expression,
    Reference,
    UnaryExpression,
    resolve,
)
from rtgen.compiler.model.tecs import Sizes, TecsFunction, TecsStruct
from rtgen.compiler.model.types import ScopedName
from rtgen.facts.tdr import LETTERS, Scalar


class Octets(msgspec.Struct, eq=False):
    """The octets in which TDR transfers values of a unit's C types, as texts that can be compared.

    Names of types, members and enumerators do not travel, and are no part of the texts. Structs are
    numbered in `numbers`, which the units of both versions share.
    """

    structs: Mapping[ScopedName, TecsStruct]
    _numbers: dict[object, int]
    _known: dict[ScopedName, str] = {}

    def of(self, type_: CType) -> str:
        """Return what determines the octets of a value."""
        return self._of(type_, ())[0]

    def _of(self, type_: CType, around: tuple[ScopedName, ...]) -> tuple[str, int]:
        """Return also the outermost struct of those `around` that the type refers to."""
        outermost = len(around)
        match resolve(type_):
            case CScalarType(kind=Scalar.VOID):
                text = "void"
            case CScalarType(kind=kind):
                text = LETTERS.get(kind, kind.value) + ("o" if kind in OCTETS else "")
            case CPointerType(target=target):
                inner, outermost = self._of(target, around)
                text = f"*{inner}"
            case CArrayType(element=element, size=size):
                inner, outermost = self._of(element, around)
                text = f"[{'' if size is None else size}]{inner}"
            case CStructType(tag=tag) if tag in around:
                outermost = around.index(tag)
                text = f"struct ^{len(around) - outermost}"
            case CStructType(tag=tag) if tag in self.structs:
                return self._struct(self.structs[tag], around)
            case CStructType(tag=tag):
                text = f"struct {'::'.join(tag)}"
            case CEnumType(bits=bits):
                text = f"enum{bits or ''}"
            case other:
                text = type(other).__name__
        return text, outermost

    def _struct(
        self, struct: TecsStruct, around: tuple[ScopedName, ...]
    ) -> tuple[str, int]:
        known = self._known.get(struct.name)
        if known is not None:
            return known, len(around)
        outermost = len(around)
        members = []
        names = [m.name for m in struct.members]
        for member in struct.members:
            text, lowest = self._of(member.type, (*around, struct.name))
            members.append((text, sizes_of(member.sizes, names)))
            outermost = min(outermost, lowest)
        key = tuple(members)
        text = f"struct {self._numbers.setdefault(key, len(self._numbers))}"
        if outermost == len(around):
            self._known[struct.name] = text
        return text, outermost

    def function(self, function: TecsFunction) -> object:
        """Return what determines the messages of a function."""
        names = [p.name for p in function.parameters]
        return (
            *(function.id, function.oneway),
            *(self.of(function.returns), is_error_code(function.returns)),
            *(
                (p.direction, self.of(p.type), sizes_of(p.sizes, names))
                for p in function.parameters
            ),
        )


def sizes_of(sizes: Sizes, names: Sequence[str]) -> tuple[object, ...]:
    """Return size specifiers with the positions of the parameters or members that they name."""
    places = {name: f"#{place}" for place, name in enumerate(names)}
    lengths = (sizes.size_is, sizes.count_is, sizes.string)
    return (
        *(length_text(each, places) for each in lengths),
        *(sizes.max_size, sizes.unsized_string, sizes.nullable),
    )


def named(type_: CType, names: Mapping[ScopedName, ScopedName]) -> str:
    """Return a type in C without typedefs, with the names of structs in the new version."""
    match resolve(type_):
        case CScalarType(kind=kind):
            return str(kind)
        case CPointerType(target=target):
            return f"*{named(target, names)}"
        case CArrayType(element=element, size=size):
            return f"[{size}]{named(element, names)}"
        case CStructType(tag=tag):
            return f"struct {'::'.join(names.get(tag, tag))}"
        case other:
            return str(other)


def structs_in(
    type_: CType, structs: Mapping[ScopedName, TecsStruct]
) -> Iterator[ScopedName]:
    """Yield the structs in a value of the type, each once."""
    waiting = [type_]
    seen: set[ScopedName] = set()
    while waiting:
        each = resolve(waiting.pop())
        if isinstance(each, CPointerType):
            waiting.append(each.target)
        elif isinstance(each, CArrayType):
            waiting.append(each.element)
        elif isinstance(each, CStructType) and each.tag not in seen:
            seen.add(each.tag)
            if each.tag in structs:
                yield each.tag
                waiting += (m.type for m in structs[each.tag].members)


def length_text(expression: Expression | None, names: Mapping[str, str]) -> str:
    """Return an expression with the parameter names of the new version."""
    match expression:
        case None:
            return "none"
        case Reference(name):
            return names.get(name, name)
        case UnaryExpression(operator, operand):
            return f"{operator}{length_text(operand, names)}"
        case BinaryExpression(operator, left, right):
            ends = length_text(left, names), length_text(right, names)
            return f"({ends[0]} {operator} {ends[1]})"
        case CastExpression(type_, operand):
            return f"({type_}){length_text(operand, names)}"
        case ConditionalExpression(condition, yes, no):
            parts = (length_text(part, names) for part in (condition, yes, no))
            return " ? ".join(parts)
    return str(expression)
