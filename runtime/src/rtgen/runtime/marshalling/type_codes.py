"""Type codes: descriptors as octets, and back (CORBA 3.3 part 2, 9.3.5).

Parameters are in encapsulations, which are written little-endian. A type that was already written,
or is being written, is referred to by an indirection. A type that equals a generated type (same
repository id, same structure) is read as its descriptor; other types are supported as well.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from rtgen.facts.primitives import (
    INTEGERS,
    TYPE_CODE_KINDS,
    Scalar,
    integer_range,
)
from rtgen.runtime.marshalling.comparison import known
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BoxDescriptor,
    BranchDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MemberDescriptor,
    Named,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
    until_registration,
)
from rtgen.runtime.marshalling.errors import Fault
from rtgen.runtime.marshalling.octets import text_octets, text_value

_Paddings: TypeAlias = tuple[tuple[int, int], ...]
_K = TypeVar("_K")
_V = TypeVar("_V")

_SIMPLE = {kind: str(name) for name, kind in TYPE_CODE_KINDS.items()}
_OBJREF, _STRUCT, _UNION, _ENUM, _STRING, _SEQUENCE, _ARRAY = 14, 15, 16, 17, 18, 19, 20
_ALIAS, _EXCEPT, _WSTRING, _FIXED, _VALUE, _BOX = 21, 22, 27, 28, 29, 30
_NATIVE, _ABSTRACT, _LOCAL, _COMPONENT, _HOME, _EVENT = 31, 32, 33, 34, 35, 36
_INDIRECTION = 0xFFFFFFFF
STRINGS = _STRING, _WSTRING
"""Kinds whose parameter is a bound."""
AGGREGATED = _STRUCT, _UNION
"""Kinds of structs and unions."""
FIXED = _FIXED
"""Kind whose parameters are digits and scale."""
ENCAPSULATED = frozenset(range(_OBJREF, _EVENT + 1)) - {
    *(*STRINGS, _FIXED, _NATIVE),
    *_SIMPLE,
}
"""Kinds whose parameters are in an encapsulation."""
_MODIFIERS = ("", "custom", "abstract", "truncatable")
_VALUE_BASE = ValueDescriptor("IDL:omg.org/CORBA/ValueBase:1.0", "ValueBase", ())
_OBJECT = InterfaceDescriptor("", "Object")
_OBJECT_IDS = ("", "IDL:omg.org/CORBA/Object:1.0")


def _first_unused(integer: Scalar) -> tuple[int, int]:
    least, greatest = integer_range(integer)
    return (least, 1) if least < 0 else (greatest, -1)


_LABELS = {
    **{
        name: (scalar.code, *_first_unused(scalar))
        for name, scalar in INTEGERS.items()
        if name in TYPE_CODE_KINDS
    },
    "char": ("B", 255, -1),
    "wchar": ("H", 0xFFFF, -1),
    "boolean": ("B", 0, 1),
}
"""Code of a label, and start and step of the search for an unused one."""

MAX_DEPTH = 100
"""Maximum nesting of encapsulations."""

_MAX_CACHED = 256
"""Maximum number of cached type codes; a full table is cleared."""
MAX_CACHED_OCTETS = 4096
"""Maximum size of a cached type code."""

_WRITTEN: dict[tuple[int, bool], tuple[Any, int, bytes]] = {}
"""By the descriptor's identity and the byte order: descriptor, kind, parameters."""
_READ: dict[tuple[int, int, bytes], tuple[_Paddings, bytes, Descriptor]] = (
    until_registration({})
)
"""By kind, size and repository id: padding, encapsulation with padding of 0, type."""
_READ_EXACTLY: dict[tuple[int, bytes], Descriptor] = until_registration({})
"""By kind and encapsulation."""


def type_code_octets(descriptor: Any, little_endian: bool) -> tuple[int, bytes]:
    """Return the kind of a type code and its parameters, which begin at a multiple of 4."""
    octets = _WRITTEN.get((id(descriptor), little_endian))
    if octets is not None:
        return octets[1:]
    if isinstance(descriptor, StringDescriptor):
        bound = descriptor.bound or 0
        parameters = bound.to_bytes(4, "little" if little_endian else "big")
        return _WSTRING if descriptor.wide else _STRING, parameters
    writer = _Writer()
    writer.type(descriptor, little_endian)
    kind = struct.unpack_from("<I" if little_endian else ">I", writer.out)[0]
    parameters = bytes(writer.out[4:])
    if isinstance(descriptor, Named) and len(parameters) <= MAX_CACHED_OCTETS:
        _keep(_WRITTEN, (id(descriptor), little_endian), (descriptor, kind, parameters))
    return kind, parameters


def known_type(kind: int, encapsulation: bytes) -> Descriptor | None:
    """Return the type of a type code that was read before; None for another one."""
    if len(encapsulation) > MAX_CACHED_OCTETS:
        return None
    return _READ_EXACTLY.get((kind, encapsulation))


def type_of_code(kind: int, encapsulation: bytes) -> Descriptor:
    """Return the type of a kind whose parameters are in the encapsulation. Raises Fault."""
    descriptor = _READ_EXACTLY.get((kind, encapsulation))
    if descriptor is None:
        descriptor = _type_of_code(kind, encapsulation)
        if len(encapsulation) <= MAX_CACHED_OCTETS:
            _keep(_READ_EXACTLY, (kind, encapsulation), descriptor)
    return descriptor


def type_at_start(octets: bytes, little_endian: bool) -> Descriptor:
    """Return the type of a type code that is all of the octets. Raises Fault or struct.error."""
    order = "<" if little_endian else ">"
    (kind,) = struct.unpack_from(f"{order}I", octets)
    offset = 4

    def number(code: str) -> int:
        nonlocal offset
        offset += struct.calcsize(f"<{code}")
        here = offset - struct.calcsize(f"<{code}")
        return int(struct.unpack_from(order + code, octets, here)[0])

    type_ = simple_type(kind, number)
    return type_of_code(kind, octets[8:]) if type_ is None else type_


def _type_of_code(kind: int, encapsulation: bytes) -> Descriptor:
    if kind in (_SEQUENCE, _ARRAY) or not 8 < len(encapsulation) <= MAX_CACHED_OCTETS:
        return _Reader(encapsulation).parameters(kind)
    end = 8 + int.from_bytes(
        encapsulation[4:8], "little" if encapsulation[0] else "big"
    )
    key = kind, len(encapsulation), encapsulation[8:end]
    type_ = _READ.get(key)
    if type_ is not None:
        paddings, octets, descriptor = type_
        if _with_zeros(encapsulation, paddings) == octets:
            return descriptor
    reader = _Reader(encapsulation)
    descriptor = reader.parameters(kind)
    paddings = tuple(reader.paddings)
    octets = bytes(_with_zeros(encapsulation, paddings))
    _keep(_READ, key, (paddings, octets, descriptor))
    return descriptor


def _with_zeros(encapsulation: bytes, paddings: _Paddings) -> bytearray:
    """Return the octets with padding of 0: omniORB's padding is not initialized."""
    octets = bytearray(encapsulation)
    for start, end in paddings:
        octets[start:end] = bytes(end - start)
    return octets


def _keep(table: dict[_K, _V], key: _K, value: _V) -> None:
    if len(table) >= _MAX_CACHED:
        table.clear()
    table[key] = value


class _Writer:
    def __init__(self) -> None:
        self.out = bytearray()
        self._base = 0
        self._order = "<"
        self._places: dict[str | int, int] = {}

    def type(self, descriptor: Any, little_endian: bool = True) -> None:
        self._order = "<" if little_endian else ">"
        match descriptor:
            case PrimitiveDescriptor("Object"):
                self._named(_OBJREF, _OBJECT, None)
            case PrimitiveDescriptor("ValueBase"):
                self._named(_VALUE, _VALUE_BASE, lambda: self._value(_VALUE_BASE))
            case PrimitiveDescriptor(name) if name in TYPE_CODE_KINDS:
                self._number("I", TYPE_CODE_KINDS[name])
            case StringDescriptor(wide, bound):
                self._number("I", _WSTRING if wide else _STRING)
                self._number("I", bound or 0)
            case FixedDescriptor(digits, scale):
                self._number("I", _FIXED)
                self._number("H", digits)
                self._number("h", scale)
            case SequenceDescriptor(element, bound):
                self._bounded(_SEQUENCE, element, bound or 0)
            case ArrayDescriptor(element, (length, *inner)):
                rows = ArrayDescriptor(element, tuple(inner)) if inner else element
                self._bounded(_ARRAY, rows, length)
            case AliasDescriptor(target=target):
                self._named(_ALIAS, descriptor, lambda: self.type(target))
            case LinkDescriptor():
                self.type(plain(descriptor), little_endian)
            case StructDescriptor(members=members):
                self._named(_STRUCT, descriptor, lambda: self._members(members))
            case ExceptionDescriptor(members=members):
                self._named(_EXCEPT, descriptor, lambda: self._members(members))
            case UnionDescriptor():
                self._named(_UNION, descriptor, lambda: self._union(descriptor))
            case EnumDescriptor():
                self._named(_ENUM, descriptor, lambda: self._enum(descriptor))
            case InterfaceDescriptor(abstract=abstract, local=local):
                kind = _ABSTRACT if abstract else _LOCAL if local else _OBJREF
                self._named(kind, descriptor, None)
            case ValueDescriptor():
                self._named(_VALUE, descriptor, lambda: self._value(descriptor))
            case BoxDescriptor(target=target):
                self._named(_BOX, descriptor, lambda: self.type(target))
            case _:
                raise Fault(f"{descriptor} has no type code")

    def _number(self, code: str, number: int) -> None:
        octets = struct.pack(self._order + code, number)
        self._align(len(octets))
        self.out += octets

    def _align(self, align: int) -> None:
        self.out += bytes(-(len(self.out) - self._base) % align)

    def _text(self, text: str) -> None:
        octets = text_octets(text) + b"\0"
        self._number("I", len(octets))
        self.out += octets

    def _named(self, kind: int, named: Any, fill: Callable[[], None] | None) -> None:
        """Write a type with a repository id, or an indirection to it."""
        self._align(4)
        key = named.repository_id or id(named)
        place = self._places.get(key)
        if place is not None:
            self._number("I", _INDIRECTION)
            self._number("i", place - len(self.out))
            return
        self._places[key] = len(self.out)

        def parameters() -> None:
            self._text(named.repository_id)
            self._text(named.name.rpartition("::")[2])
            if fill is not None:
                fill()

        self._encapsulated(kind, parameters)

    def _bounded(self, kind: int, element: Descriptor, bound: int) -> None:
        def parameters() -> None:
            self.type(element)
            self._number("I", bound)

        self._encapsulated(kind, parameters)

    def _encapsulated(self, kind: int, parameters: Callable[[], None]) -> None:
        order, base = self._order, self._base
        self._number("I", kind)
        self.out += bytes(4)
        start = self._base = len(self.out)
        self.out += b"\1"
        self._order = "<"
        parameters()
        self._order, self._base = order, base
        struct.pack_into(f"{order}I", self.out, start - 4, len(self.out) - start)

    def _members(self, members: tuple[MemberDescriptor, ...]) -> None:
        self._number("I", len(members))
        for member in members:
            if member.optional:
                raise Fault(f"{member.name} is optional: that has no type code")
            self._text(member.name)
            self.type(member.type)

    def _enum(self, descriptor: EnumDescriptor) -> None:
        self._number("I", len(descriptor.members))
        for name, _ in descriptor.members:
            self._text(name)

    def _value(self, descriptor: ValueDescriptor) -> None:
        self._number("h", _MODIFIERS.index(descriptor.modifier))
        self.type(descriptor.concrete_base() or PrimitiveDescriptor("null"))
        self._number("I", len(descriptor.members))
        for member in descriptor.members:
            self._text(member.name)
            self.type(member.type)
            self._number("h", 0 if member.private else 1)

    def _union(self, descriptor: UnionDescriptor) -> None:
        switch = plain(descriptor.switch)
        self.type(descriptor.switch)
        entries: list[tuple[Any, BranchDescriptor]] = []
        default = -1
        for branch in descriptor.branches:
            entries += [(label, branch) for label in branch.labels]
            if branch.default:
                default = len(entries)
                entries.append((None, branch))
        self._number("i", default)
        self._number("I", len(entries))
        used = {_label_number(label) for label, _ in entries if label is not None}
        for label, branch in entries:
            self._label(switch, label, used)
            self._text(branch.name)
            self.type(branch.type)

    def _label(self, switch: Descriptor, label: Any, used: set[int]) -> None:
        """Write a label; the default's is a discriminator that no other branch has."""
        if isinstance(switch, EnumDescriptor):
            code, number, step = switch.code, 0, 1
        elif isinstance(switch, PrimitiveDescriptor) and switch.name in _LABELS:
            code, number, step = _LABELS[switch.name]
        else:
            raise Fault(f"a union that switches on {switch} has no type code")
        if label is not None:
            number = _label_number(label)
        while label is None and number in used:
            number += step
        if code == "H" and switch == PrimitiveDescriptor("wchar"):
            self.out += b"\2" + number.to_bytes(2)
        else:
            self._number(code, number)


def _label_number(label: int | str | bool) -> int:
    return ord(label) if isinstance(label, str) else int(label)


class _Reader:
    """Reads the parameters of a type code in an encapsulation, which begins 8 after its kind."""

    def __init__(self, encapsulation: bytes) -> None:
        self.paddings: list[tuple[int, int]] = []
        """Start and end of each padding in the encapsulation."""
        self._data = bytes(8) + encapsulation
        self._offset = 8
        self._end = len(self._data)
        self._base = 8
        self._order = "<"
        self._depth = 0
        self._begun: dict[int, tuple[str, str]] = {}
        self._done: dict[int, Descriptor] = {}

    def parameters(self, kind: int) -> Descriptor:
        """Return the type of a kind whose parameters are in the encapsulation."""
        return self._inside(kind, 0, self._end)

    def _type(self) -> Descriptor:
        self._align(4)
        place = self._offset
        kind = self._number("I")
        if kind == _INDIRECTION:
            return self._referred()
        simple = simple_type(kind, self._number)
        if simple is not None:
            return simple
        length = self._number("I")
        if length > self._end - self._offset:
            raise Fault("a type code is longer than its enclosing encapsulation")
        base, order, end = self._base, self._order, self._end
        self._base = self._offset
        stop = self._offset + length
        descriptor = self._inside(kind, place, stop)
        self._base, self._order, self._end, self._offset = base, order, end, stop
        return descriptor

    def _inside(self, kind: int, place: int, end: int) -> Descriptor:
        self._end = end
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise Fault(f"a type code is nested more than {MAX_DEPTH} deep")
        self._order = "<" if self._octet() else ">"
        if kind in (_SEQUENCE, _ARRAY):
            descriptor = self._collection(kind)
        else:
            descriptor = self._named(kind, place)
        self._depth -= 1
        self._done[place] = descriptor
        return descriptor

    def _referred(self) -> Descriptor:
        here = self._offset + -(self._offset - self._base) % 4
        place = here + self._number("i")
        if place in self._done:
            return self._done[place]
        if place not in self._begun:
            raise Fault("an indirection in a type code leads nowhere")

        def target() -> Descriptor:
            return self._done[place]

        return LinkDescriptor(*self._begun[place], target=target)

    def _octet(self) -> int:
        return self._number("B")

    def _number(self, code: str) -> int:
        size = struct.calcsize(f"<{code}")
        self._align(size)
        if size > self._end - self._offset:
            raise Fault("a type code ends too soon")
        (number,) = struct.unpack_from(self._order + code, self._data, self._offset)
        self._offset += size
        return int(number)

    def _align(self, align: int) -> None:
        padding = -(self._offset - self._base) % align
        if padding:
            start = self._offset - 8
            self.paddings.append((start, start + padding))
            self._offset += padding

    def _text(self) -> str:
        length = self._count(1)
        self._offset += length
        return text_value(self._data[self._offset - length : self._offset])

    def _count(self, least: int) -> int:
        count = self._number("I")
        if count * least > self._end - self._offset:
            raise Fault(f"a type code of {count} parts ends too soon")
        return count

    def _collection(self, kind: int) -> Descriptor:
        element = self._type()
        bound = self._number("I")
        if kind == _SEQUENCE:
            return SequenceDescriptor(element, bound or None)
        if not bound:
            raise Fault("an array without elements in a type code")
        if isinstance(element, ArrayDescriptor):
            return ArrayDescriptor(element.element, (bound, *element.dimensions))
        return ArrayDescriptor(element, (bound,))

    def _named(self, kind: int, place: int) -> Descriptor:
        repository_id, name = self._text(), self._text()
        self._begun[place] = (repository_id, name)
        head = (repository_id, name)
        match kind:
            case 14 | 32 | 33 | 34 | 35:
                if kind == _OBJREF and repository_id in _OBJECT_IDS:
                    return PrimitiveDescriptor("Object")
                return known(
                    InterfaceDescriptor(
                        *head, abstract=kind == _ABSTRACT, local=kind == _LOCAL
                    )
                )
            case 15:
                return known(StructDescriptor(*head, self._members()))
            case 22:
                return known(ExceptionDescriptor(*head, self._members()))
            case 17:
                names = [self._text() for _ in range(self._count(5))]
                numbered = tuple((n, i) for i, n in enumerate(names))
                return known(EnumDescriptor(*head, numbered))
            case 16:
                return known(self._union(head))
            case 21:
                return AliasDescriptor(*head, self._type())
            case 30:
                return known(BoxDescriptor(*head, self._type()))
            case 29 | 36:
                if repository_id == _VALUE_BASE.repository_id:
                    return PrimitiveDescriptor("ValueBase")
                return known(self._value(head))
        raise Fault(f"a type code of kind {kind}")

    def _members(self) -> tuple[MemberDescriptor, ...]:
        count = self._count(9)
        return tuple(MemberDescriptor(self._text(), self._type()) for _ in range(count))

    def _value(self, head: tuple[str, str]) -> ValueDescriptor:
        modifier = self._number("h")
        if not 0 <= modifier < len(_MODIFIERS):
            raise Fault(f"a value modifier {modifier} in a type code")
        base = plain_value(self._type())
        members = []
        for _ in range(self._count(11)):
            name, type_ = self._text(), self._type()
            private = self._number("h") == 0
            members.append(MemberDescriptor(name, type_, name, private=private))
        bases = () if base is None else (base,)
        return ValueDescriptor(*head, tuple(members), bases, _MODIFIERS[modifier])

    def _union(self, head: tuple[str, str]) -> UnionDescriptor:
        switch = self._type()
        default = self._number("i")
        branches: list[BranchDescriptor] = []
        for index in range(self._count(10)):
            label = self._label(plain(switch))
            name, type_ = self._text(), self._type()
            last = branches[-1] if branches else None
            joined = last is not None and last.name == name
            labels = last.labels if last is not None and joined else ()
            is_default = index == default
            if not is_default:
                labels = (*labels, label)
            is_default |= last is not None and joined and last.default
            if joined:
                branches.pop()
            branches.append(BranchDescriptor(labels, is_default, name, type_))
        return UnionDescriptor(*head, switch, tuple(branches))

    def _label(self, switch: Descriptor) -> int | str | bool:
        if isinstance(switch, EnumDescriptor):
            return self._number(switch.code)
        if not isinstance(switch, PrimitiveDescriptor) or switch.name not in _LABELS:
            raise Fault(f"a type code of a union that switches on {switch}")
        if switch.name == "wchar":
            self._octet()
            return chr(self._octet() << 8 | self._octet())
        number = self._number(_LABELS[switch.name][0])
        if switch.name == "char":
            return chr(number)
        return bool(number) if switch.name == "boolean" else number


def plain_value(descriptor: Descriptor) -> ValueDescriptor | None:
    """Return the concrete base in a valuetype's type code; None for `null`."""
    if descriptor == PrimitiveDescriptor("null"):
        return None
    descriptor = plain(descriptor)
    if not isinstance(descriptor, ValueDescriptor):
        raise Fault(f"a value cannot derive from {descriptor}")
    return descriptor


def simple_type(kind: int, number: Callable[[str], int]) -> Descriptor | None:
    """Return the type of a kind without an encapsulation; `number` reads its parameters."""
    if kind in _SIMPLE:
        return PrimitiveDescriptor(_SIMPLE[kind])
    if kind in (_STRING, _WSTRING):
        return StringDescriptor(kind == _WSTRING, number("I") or None)
    if kind == _FIXED:
        digits = number("H")
        scale = number("h")
        if not 0 < digits <= 31 or not 0 <= scale <= digits:
            raise Fault(f"fixed<{digits},{scale}> in a type code")
        return FixedDescriptor(digits, scale)
    if not _OBJREF <= kind <= _EVENT or kind == _NATIVE:
        raise Fault(f"a type code of kind {kind}")
    return None
