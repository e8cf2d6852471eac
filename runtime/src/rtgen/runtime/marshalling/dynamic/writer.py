"""Marshals classic CDR by descriptors: types known only at run time, and rare ones.

Compiled codecs call it for `any`, type codes, values and abstract interfaces; when a compiled
codec fails, it marshals the whole value again to locate the fault. CORBA 3.3 part 2, 9.3.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Set, Sized
from functools import partial
from typing import Any, NoReturn

from rtgen.facts.primitives import OCTET_TYPES
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.checks import (
    CODES,
    TEXTS,
    bits_code,
    check_bound,
    check_string,
    packed,
    size_of,
)
from rtgen.runtime.marshalling.dynamic.direct import compiled_class
from rtgen.runtime.marshalling.dynamic.forms import listed
from rtgen.runtime.marshalling.errors import LOCATED, Fault, located
from rtgen.runtime.marshalling.octets import (
    ObjectReference,
    fixed_octets,
    octets_in,
    quad_octets,
    text_octets,
    wide_character,
    wide_octets,
    write_reference,
)
from rtgen.runtime.marshalling.type_codes import type_code_octets

NULL_TAG = 0
INDIRECTION = 0xFFFFFFFF
VALUE_TAG = 0x7FFFFF00
CODEBASE, ONE_ID, ID_LIST, CHUNKED = 1, 2, 6, 8
"""Bits of a value tag (9.3.4.1)."""


class Output(bytearray):
    """The output body, with the offsets of shared values and ids."""

    __slots__ = ("ids", "values")

    def __init__(self) -> None:
        super().__init__()
        self.values: dict[int, tuple[int, object]] = {}
        self.ids: dict[str | tuple[str, ...], int] = {}


def write_dynamic(
    out: bytearray, value: object, descriptor: Descriptor, little_endian: bool
) -> None:
    """Append a value of the descriptor to a body. Raises ValueError or a related error."""
    Writer(out, little_endian).value(descriptor, value)


class Writer:
    """Appends values to a body. Raises Fault for an invalid value.

    `walking`: compiled codecs are not used, so that a fault has a complete path.
    """

    def __init__(
        self, out: bytearray, little_endian: bool, walking: bool = False
    ) -> None:
        self._walking = walking
        self._out = out
        self._shared = out if isinstance(out, Output) else Output()
        self._little = bool(little_endian)
        self._order = "<" if little_endian else ">"
        self._level = 0
        self._chunk = -1
        self._ended = -1

    def value(self, descriptor: Descriptor, value: Any) -> None:
        """Append a value of any type."""
        match descriptor:
            case LinkDescriptor() | AliasDescriptor():
                self.value(plain(descriptor), value)
            case PrimitiveDescriptor(name):
                self._primitive(name, value)
            case StringDescriptor(wide, bound):
                self._string(value, wide, bound)
            case FixedDescriptor(digits, scale):
                self._put(fixed_octets(value, digits, scale), 1)
            case EnumDescriptor(members=members, code=code):
                if value not in [number for _, number in members]:
                    raise Fault(f"{value!r} is not a member of {descriptor.name}")
                self._number(code, value)
            case FlagsDescriptor(bound=bound):
                if not isinstance(value, int) or not 0 <= value < 1 << bound:
                    raise Fault(f"{value!r} is not a value of {descriptor.name}")
                self._number(bits_code(bound), value)
            case BitsetDescriptor(bound=bound):
                self._number(bits_code(bound), _bits(descriptor, value))
            case SequenceDescriptor(element, bound):
                self._sequence(element, bound, listed(descriptor, value))
            case ArrayDescriptor(element, dimensions):
                self._array(element, dimensions, listed(descriptor, value))
            case MapDescriptor(key, item, bound):
                self._map(key, item, bound, value)
            case StructDescriptor() | UnionDescriptor():
                class_ = None if self._walking else compiled_class(descriptor)
                if class_ is not None and type(value) is class_ and not self._level:
                    class_._write_(value, self._out, self._little)
                elif isinstance(descriptor, UnionDescriptor):
                    self._union(descriptor, value)
                else:
                    self.members(descriptor, value)
            case ExceptionDescriptor():
                self.members(descriptor, value)
            case InterfaceDescriptor(abstract=True):
                self._abstract(value)
            case InterfaceDescriptor():
                self._reference(value)
            case ValueDescriptor() | BoxDescriptor():
                self._valued(descriptor, value)

    def members(
        self, descriptor: StructDescriptor | ExceptionDescriptor, value: Any
    ) -> None:
        """Append the members of a struct or exception."""
        part = ""
        try:
            for member in descriptor.members:
                part = ""
                inner = _attribute(value, member.attribute, descriptor.name)
                part = f".{member.name}"
                if inner is not None or not member.optional:
                    self.value(member.type, inner)
        except LOCATED as failure:
            raise located(failure, part) from failure

    # Octets, and chunks inside a value

    def _put(self, octets: bytes | bytearray, align: int) -> None:
        out = self._out
        if self._level and self._chunk < 0:
            out += bytes(-len(out) % 4)
            self._chunk = len(out)
            out += bytes(4)
        out += bytes(-len(out) % align) + octets

    def _number(self, code: str, number: int | float) -> None:
        octets = struct.pack(self._order + code, number)
        self._put(octets, len(octets))

    def _close_chunk(self) -> None:
        """Write the size of the open chunk."""
        if self._chunk >= 0:
            size = len(self._out) - self._chunk - 4
            struct.pack_into(f"{self._order}i", self._out, self._chunk, size)
            self._chunk = -1

    # Basic types and strings.

    def _primitive(self, name: str, value: Any) -> None:
        match name:
            case "boolean":
                if value not in (False, True):
                    raise Fault(f"a bool is needed, not {value!r}")
                self._put(b"\1" if value else b"\0", 1)
            case "char":
                if not isinstance(value, str) or len(value) != 1 or ord(value) > 255:
                    raise Fault(f"one character of ISO 8859-1 is needed, not {value!r}")
                self._put(value.encode("latin-1"), 1)
            case "wchar":
                self._put(wide_character(value), 1)
            case "long double":
                self._put(quad_octets(value, self._little), 8)
            case "Object":
                self._reference(value)
            case "any":
                self.any(value)
            case "CORBA::TypeCode":
                self._type_code(value)
            case "ValueBase":
                self._valued(None, value)
            case "null" | "void":
                if value is not None:
                    raise Fault(f"{name} has no value, so not {value!r}")
            case _:
                self._put(packed(CODES[name], name, value, self._order), size_of(name))

    def _string(self, value: Any, wide: bool, bound: int | None) -> None:
        if not isinstance(value, str):
            raise Fault(f"a str is needed, not {type(value).__name__}")
        octets = (wide_octets if wide else text_octets)(value)
        check_string(value, wide, bound)
        self._number("I", len(octets) + (not wide))
        self._put(octets if wide else octets + b"\0", 1)

    def _text(self, element: Descriptor, value: Any) -> bytes | bytearray | None:
        """Return a collection's octets if it is `bytes` or `str`; None for other elements."""
        element = plain(element)
        name = element.name if isinstance(element, PrimitiveDescriptor) else ""
        if name not in TEXTS:
            return None
        if name in OCTET_TYPES:
            return octets_in(value)
        if not isinstance(value, str):
            raise Fault(f"str are needed, not {type(value).__name__}")
        for index, character in enumerate(value):
            if ord(character) > 255:
                raise located(
                    Fault(f"{character!r} is not in ISO 8859-1"), f"[{index}]"
                )
        return value.encode("latin-1")

    # Collections.

    def _sequence(self, element: Descriptor, bound: int | None, value: Any) -> None:
        octets = self._text(element, value)
        if octets is not None:
            check_bound(len(octets), bound, "items")
            self._number("I", len(octets))
            self._put(octets, 1)
            return
        count = _length(value)
        if bound is not None and count > bound:
            self._check_items(element, value)
            check_bound(count, bound, "items")
        self._number("I", count)
        self._items(value, partial(self.value, element))

    def _check_items(self, element: Descriptor, value: Any) -> None:
        """Raise the fault of an item in preference to one of the collection."""
        writer = Writer(Output(), self._little, walking=True)
        writer._items(value, partial(writer.value, element))

    def _items(self, value: Any, write: Callable[[Any], None]) -> None:
        index = -1
        try:
            iterator = iter(value)
        except TypeError:
            raise Fault(f"a list is needed, not {type(value).__name__}") from None
        try:
            for index, item in enumerate(iterator):  # noqa: B007
                write(item)
        except LOCATED as failure:
            raise located(failure, f"[{index}]") from failure
        if index + 1 != len(value):
            raise Fault(f"{index + 1} items, and its length is {len(value)}")

    def _array(
        self, element: Descriptor, dimensions: tuple[int, ...], value: Any
    ) -> None:
        octets = self._text(element, value) if len(dimensions) == 1 else None
        if octets is not None:
            _exact(len(octets), dimensions[0])
            self._put(octets, 1)
            return
        count = _length(value)
        write = partial(self.value, element)
        if len(dimensions) > 1:
            _exact(count, dimensions[0])
            row = ArrayDescriptor(element, dimensions[1:])
            write = partial(self._row, row)
        elif count != dimensions[0]:
            self._check_items(element, value)
            _exact(count, dimensions[0])
        self._items(value, write)

    def _row(self, row: ArrayDescriptor, value: Any) -> None:
        self._array(row.element, row.dimensions, listed(row, value))

    def _map(
        self, key: Descriptor, item: Descriptor, bound: int | None, value: Any
    ) -> None:
        if not isinstance(value, dict):
            raise Fault(f"a dict is needed, not {type(value).__name__}")
        check_bound(len(value), bound, "items")
        self._number("I", len(value))
        part = ""
        try:
            for k, v in value.items():
                part = f"[{k!r}]"
                self.value(key, k)
                self.value(item, v)
        except LOCATED as failure:
            raise located(failure, part) from failure

    # Constructed types.

    def _union(self, descriptor: UnionDescriptor, value: Any) -> None:
        discriminator = _attribute(value, "discriminator", descriptor.name)
        part = ".discriminator"
        try:
            self.value(descriptor.switch, discriminator)
            branch = descriptor.branch(discriminator)
            if branch is not None:
                part = f".{branch.name}"
                self.value(branch.type, value.value)
        except LOCATED as failure:
            raise located(failure, part) from failure
        if branch is None and value.value is not None:
            raise Fault(f"no branch has the discriminator {discriminator!r}")

    def _reference(self, value: Any) -> None:
        if value is not None and not isinstance(value, ObjectReference):
            raise Fault(f"an object reference is needed, not {type(value).__name__}")
        if not self._level:
            write_reference(self._out, value, self._little)
            return
        reference = value or ObjectReference()
        self._string(reference.type_id, False, None)
        self._number("I", len(reference.profiles))
        for tag, octets in reference.profiles:
            self._number("I", tag)
            self._number("I", len(octets))
            self._put(octets, 1)

    def _abstract(self, value: Any) -> None:
        """Append an object reference, or a value that supports the interface (9.3.7)."""
        is_reference = isinstance(value, ObjectReference)
        self._put(b"\1" if is_reference else b"\0", 1)
        if is_reference:
            self._reference(value)
        else:
            self._valued(None, value)

    # Any and type codes.

    def any(self, value: Any) -> None:
        """Append an `any`."""
        if getattr(value, "_descriptor_", None) is not ANY:
            raise Fault(f"an AnyValue is needed, not {type(value).__name__}")
        self._type_code(value.type)
        described = plain(value.type)
        if isinstance(described, ExceptionDescriptor):
            self._string(described.repository_id, False, None)
        try:
            self.value(described, value.value)
        except LOCATED as failure:
            raise located(failure, ".value") from failure

    def _type_code(self, value: Any) -> None:
        kind, parameters = type_code_octets(value, self._little)
        self._number("I", kind)
        if parameters:
            self._put(parameters, 4)

    # Values (9.3.4).

    def _valued(
        self, formal: ValueDescriptor | BoxDescriptor | None, value: Any
    ) -> None:
        if value is None:
            self._number("I", NULL_TAG)
            return
        described = getattr(value, "described", None)
        actual = None if described is None else described()
        if not isinstance(actual, ValueDescriptor | BoxDescriptor):
            raise Fault(f"a value is needed, not {type(value).__name__}")
        if formal is not None and not actual.is_a(formal.repository_id):
            raise Fault(f"a {formal.name} is needed, not a {actual.name}")
        position = self._shared.values.get(id(value))
        if position is not None:
            self._number("I", INDIRECTION)
            self._put(b"", 4)
            self._number("i", position[0] - len(self._out))
            return
        if isinstance(actual, ValueDescriptor) and actual.modifier == "custom":
            raise Fault(f"{actual.name} is custom: it has no state that is known here")
        self._close_chunk()
        self._out += bytes(-len(self._out) % 4)
        self._shared.values[id(value)] = (len(self._out), value)
        self._header(formal, actual)
        self._state(actual, value)

    def _header(
        self,
        formal: ValueDescriptor | BoxDescriptor | None,
        actual: ValueDescriptor | BoxDescriptor,
    ) -> None:
        boxed = isinstance(actual, BoxDescriptor)
        tag = VALUE_TAG | (0 if boxed and not self._level else CHUNKED)
        ids: tuple[str, ...] = ()
        if formal is None or actual.repository_id != formal.repository_id:
            ids = (actual.repository_id, *actual.truncates_to())
            tag |= ONE_ID if len(ids) == 1 else ID_LIST
        level, self._level = self._level, 0
        self._number("I", tag)
        if len(ids) == 1:
            self._id(ids[0])
        elif ids and not self._indirect(ids):
            self._number("I", len(ids))
            for repository_id in ids:
                self._id(repository_id)
        self._level = level

    def _id(self, repository_id: str) -> None:
        if not self._indirect(repository_id):
            self._string(repository_id, False, None)

    def _indirect(self, shared: str | tuple[str, ...]) -> bool:
        """Write an indirection if an id or id list was written before; return whether it was."""
        out = self._out
        out += bytes(-len(out) % 4)
        if shared in self._shared.ids:
            self._number("I", INDIRECTION)
            self._number("i", self._shared.ids[shared] - len(out))
            return True
        self._shared.ids[shared] = len(out)
        return False

    def _state(self, actual: ValueDescriptor | BoxDescriptor, value: Any) -> None:
        chunked = isinstance(actual, ValueDescriptor) or self._level > 0
        self._level += chunked
        if isinstance(actual, BoxDescriptor):
            try:
                self.value(actual.target, value.value)
            except LOCATED as failure:
                raise located(failure, ".value") from failure
        else:
            self._state_members(actual, value)
        if not chunked:
            return
        self._close_chunk()
        out = self._out
        if self._ended == len(out):
            del out[-4:]
        out += bytes(-len(out) % 4) + struct.pack(f"{self._order}i", -self._level)
        self._ended = len(out)
        self._level -= 1

    def _state_members(self, actual: ValueDescriptor, value: Any) -> None:
        part = ""
        try:
            for member in actual.all_members():
                part = f".{member.name}"
                inner = _attribute(value, member.attribute, actual.name)
                self.value(member.type, inner)
        except LOCATED as failure:
            raise located(failure, part) from failure


def _bits(descriptor: BitsetDescriptor, value: Any) -> int:
    number = 0
    part = ""
    try:
        for field in descriptor.fields:
            part = ""
            inner = _attribute(value, field.attribute, descriptor.name)
            part = f".{field.name}"
            number |= field.packed(inner) << field.position
    except LOCATED as failure:
        raise located(failure, part) from failure
    return number


def _attribute(value: Any, name: str, type_name: str) -> Any:
    try:
        return getattr(value, name)
    except AttributeError:
        message = f"a value of {type_name} is needed, not {type(value).__name__}"
        raise Fault(message) from None


def _length(value: Any) -> int:
    if not isinstance(value, Sized) or isinstance(value, str | bytes | Mapping | Set):
        _refuse_list(value)
    return len(value)


def _refuse_list(value: Any) -> NoReturn:
    raise Fault(f"a list is needed, not {type(value).__name__}")


def _exact(count: int, length: int) -> None:
    if count != length:
        raise Fault(f"{count} items instead of {length}")
