"""Where a codec failed: the value, or the octets, are walked once more along the descriptor."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sized
from functools import partial
from math import prod
from typing import Any

from rtgen.runtime.cdr import FAILURES, Buffer, CdrError
from rtgen.runtime.cdr_values import (
    ObjectReference,
    fixed_octets,
    fixed_value,
    quad_octets,
    quad_value,
    text_octets,
    text_value,
    wide_character,
    wide_character_value,
    wide_octets,
    wide_value,
    write_reference,
)
from rtgen.runtime.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    MemberDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)

_CODES = {
    "short": "h",
    "unsigned short": "H",
    "long": "i",
    "unsigned long": "I",
    "long long": "q",
    "unsigned long long": "Q",
    "int8": "b",
    "uint8": "B",
    "octet": "B",
    "boolean": "B",
    "float": "f",
    "double": "d",
}
_OCTETS = SequenceDescriptor(PrimitiveDescriptor("octet"))
_PROFILE = StructDescriptor(
    "",
    "",
    (
        MemberDescriptor("tag", PrimitiveDescriptor("unsigned long")),
        MemberDescriptor("octets", _OCTETS),
    ),
)
_REFERENCE = StructDescriptor(
    "",
    "",
    (
        MemberDescriptor("type_id", StringDescriptor()),
        MemberDescriptor("profiles", SequenceDescriptor(_PROFILE)),
    ),
)
_TEXTS = {"octet": (bytes, bytearray), "uint8": (bytes, bytearray), "char": (str,)}


def fault_in_value(
    descriptor: Descriptor, root: str, value: object, failure: Exception
) -> CdrError:
    """The first fault of a value that could not be encoded; `root` begins its path."""
    try:
        _check(descriptor, value, root)
    except CdrError as fault:
        return fault
    except RecursionError:
        return CdrError(root, "the value contains itself, or is nested too deeply")
    return CdrError(root, str(failure) or type(failure).__name__)


def fault_in_octets(
    descriptor: Descriptor,
    root: str,
    data: Buffer,
    little_endian: bool,
    failure: Exception,
) -> CdrError:
    """The first fault of octets that could not be decoded; `root` begins its path."""
    try:
        octets = bytes(memoryview(data))
    except TypeError:
        return CdrError(root, f"octets are needed, not {type(data).__name__}")
    scan = _Scan(octets, little_endian)
    try:
        scan.value(descriptor, root)
        scan.end(root)
    except CdrError as fault:
        return fault
    except RecursionError:
        return CdrError(root, "the value is nested too deeply")
    return CdrError(root, str(failure) or type(failure).__name__)


def _fail(path: str, action: Callable[[], object]) -> None:
    """Runs a conversion and gives its failure the path."""
    try:
        action()
    except CdrError:
        raise
    except FAILURES as failure:
        raise CdrError(path, str(failure)) from failure


def _check(descriptor: Descriptor, value: Any, path: str) -> None:
    match descriptor:
        case LinkDescriptor() | AliasDescriptor():
            _check(plain(descriptor), value, path)
        case PrimitiveDescriptor(name):
            _fail(path, lambda: _check_primitive(name, value))
        case StringDescriptor(wide, bound):
            if not isinstance(value, str):
                raise CdrError(path, f"a str is needed, not {type(value).__name__}")
            _fail(path, lambda: (wide_octets if wide else text_octets)(value))
            _check_string_bound(value, wide, bound, path)
        case FixedDescriptor(digits, scale):
            _fail(path, lambda: fixed_octets(value, digits, scale))
        case EnumDescriptor(members=members):
            _check_member(descriptor, members, value, path)
        case FlagsDescriptor(bound=bound):
            if not isinstance(value, int) or not 0 <= value < 1 << bound:
                raise CdrError(path, f"{value!r} is not a value of {descriptor.name}")
        case BitsetDescriptor(fields=bits):
            for bitfield in bits:
                inner = _member(value, bitfield.attribute, descriptor.name, path)
                _fail(f"{path}.{bitfield.name}", partial(bitfield.packed, inner))
        case SequenceDescriptor(element, bound):
            _check_items(element, value, path)
            _check_bound(len(value), bound, "items", path)
        case ArrayDescriptor(element, dimensions):
            _check_array(element, dimensions, value, path)
        case MapDescriptor(key, item, bound):
            if not isinstance(value, dict):
                raise CdrError(path, f"a dict is needed, not {type(value).__name__}")
            _check_bound(len(value), bound, "items", path)
            for k, v in value.items():
                _check(key, k, f"{path}[{k!r}]")
                _check(item, v, f"{path}[{k!r}]")
        case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
            for field in fields:
                inner = _member(value, field.attribute, descriptor.name, path)
                _check(field.type, inner, f"{path}.{field.name}")
        case UnionDescriptor():
            _check_union(descriptor, value, path)
        case InterfaceDescriptor():
            _check_reference(value, path)


def _check_primitive(name: str, value: Any) -> None:
    match name:
        case "boolean":
            if value not in (False, True):
                raise TypeError(f"a bool is needed, not {value!r}")
        case "char":
            if not isinstance(value, str) or len(value) != 1 or ord(value) > 255:
                raise ValueError(
                    f"one character of ISO 8859-1 is needed, not {value!r}"
                )
        case "wchar":
            wide_character(value)
        case "long double":
            quad_octets(value, False)
        case "Object":
            _check_reference(value, "")
        case _:
            try:
                struct.pack(f"<{_CODES[name]}", value)
            except struct.error as failure:
                if isinstance(value, int) and not isinstance(value, bool):
                    raise ValueError(
                        f"{value} is out of the range of {name}"
                    ) from failure
                raise TypeError(
                    f"a value of {name} is needed, not {value!r}"
                ) from failure
            except OverflowError as failure:
                raise ValueError(f"{value} is out of the range of {name}") from failure


def _check_reference(value: Any, path: str) -> None:
    if value is not None and not isinstance(value, ObjectReference):
        raise CdrError(
            path, f"an object reference is needed, not {type(value).__name__}"
        )
    _fail(path, lambda: write_reference(bytearray(), value, True))


def _check_member(
    descriptor: EnumDescriptor,
    members: tuple[tuple[str, int], ...],
    value: Any,
    path: str,
) -> None:
    if value not in [number for _, number in members]:
        raise CdrError(path, f"{value!r} is not a member of {descriptor.name}")


def _check_string_bound(text: str, wide: bool, bound: int | None, path: str) -> None:
    if wide:
        _check_bound(len(text.encode("utf-16-le")) // 2, bound, "UTF-16 units", path)
    else:
        _check_bound(len(text.encode()), bound, "octets of UTF-8", path)


def _check_bound(length: int, bound: int | None, unit: str, path: str) -> None:
    if bound is not None and length > bound:
        raise CdrError(path, f"{length} {unit}, and {bound} are the most")


def _check_text(element: Descriptor, value: Any, path: str) -> bool:
    """Whether the sequence or array is `bytes` or `str`; that it is one, then."""
    element = plain(element)
    types = (
        _TEXTS.get(element.name) if isinstance(element, PrimitiveDescriptor) else None
    )
    if types is None:
        return False
    if not isinstance(value, types):
        raise CdrError(
            path, f"{types[0].__name__} are needed, not {type(value).__name__}"
        )
    if isinstance(value, str):
        for index, character in enumerate(value):
            if ord(character) > 255:
                raise CdrError(
                    f"{path}[{index}]", f"{character!r} is not in ISO 8859-1"
                )
    return True


def _check_items(element: Descriptor, value: Any, path: str) -> None:
    if _check_text(element, value, path):
        return
    if not isinstance(value, Sized) or isinstance(value, str | dict):
        raise CdrError(path, f"a list is needed, not {type(value).__name__}")
    for index, item in enumerate(_items(value, path)):
        _check(element, item, f"{path}[{index}]")


def _items(value: Any, path: str) -> Iterator[Any]:
    try:
        return iter(value)
    except TypeError as failure:
        raise CdrError(
            path, f"a list is needed, not {type(value).__name__}"
        ) from failure


def _check_array(
    element: Descriptor, dimensions: tuple[int, ...], value: Any, path: str
) -> None:
    if len(dimensions) == 1:
        _check_items(element, value, path)
    elif not isinstance(value, Sized) or isinstance(value, str | bytes | dict):
        raise CdrError(path, f"a list is needed, not {type(value).__name__}")
    if len(value) != dimensions[0]:
        raise CdrError(path, f"{len(value)} items instead of {dimensions[0]}")
    if len(dimensions) > 1:
        for index, row in enumerate(_items(value, path)):
            _check_array(element, dimensions[1:], row, f"{path}[{index}]")


def _member(value: Any, name: str, type_name: str, path: str) -> Any:
    try:
        return getattr(value, name)
    except AttributeError as failure:
        message = f"a value of {type_name} is needed, not {type(value).__name__}"
        raise CdrError(path, message) from failure


def _check_union(descriptor: UnionDescriptor, value: Any, path: str) -> None:
    discriminator = _member(value, "discriminator", descriptor.name, path)
    _check(descriptor.switch, discriminator, f"{path}.discriminator")
    branch = descriptor.branch(discriminator)
    if branch is not None:
        _check(branch.type, value.value, f"{path}.{branch.name}")
    elif value.value is not None:
        raise CdrError(path, f"no branch has the discriminator {discriminator!r}")


class _Scan:
    """Reads octets along a descriptor; raises CdrError at the first fault."""

    def __init__(self, data: bytes, little_endian: bool) -> None:
        self._data = data
        self._little = bool(little_endian)
        self._order = "<" if little_endian else ">"
        self._offset = 0

    def end(self, path: str) -> None:
        rest = len(self._data) - self._offset
        if rest:
            raise CdrError(path, f"{rest} octets too many")

    def _octets(self, size: int, align: int, path: str) -> bytes:
        start = self._offset + -self._offset % align
        if size > len(self._data) - start:
            left = max(len(self._data) - self._offset, 0)
            raise CdrError(
                path, f"truncated: {size} octets are needed, {left} are left"
            )
        self._offset = start + size
        return self._data[start : self._offset]

    def _number(self, code: str, path: str) -> Any:
        size = struct.calcsize(f"<{code}")
        return struct.unpack(self._order + code, self._octets(size, size, path))[0]

    def _count(self, least: int, bound: int | None, path: str) -> int:
        count = int(self._number("I", path))
        left = len(self._data) - self._offset
        if count * least > left:
            raise CdrError(path, f"a length of {count}, and {left} octets are left")
        _check_bound(count, bound, "items", path)
        return count

    def value(self, descriptor: Descriptor, path: str) -> Any:
        match descriptor:
            case LinkDescriptor() | AliasDescriptor():
                return self.value(plain(descriptor), path)
            case PrimitiveDescriptor(name):
                return self._primitive(name, path)
            case StringDescriptor(wide, bound):
                octets = self._octets(self._count(1, None, path), 1, path)
                text = _converted(
                    path, lambda: (wide_value if wide else text_value)(octets)
                )
                _check_string_bound(text, wide, bound, path)
            case FixedDescriptor(digits, scale):
                octets = self._octets(digits // 2 + 1, 1, path)
                _converted(path, lambda: fixed_value(octets, digits, scale))
            case EnumDescriptor(members=members):
                number = int(self._number("I", path))
                _check_member(descriptor, members, number, path)
                return number
            case FlagsDescriptor(bound=bound) | BitsetDescriptor(bound=bound):
                code = next(
                    c
                    for c, n in zip("BHIQ", (8, 16, 32, 64), strict=True)
                    if bound <= n
                )
                number = self._number(code, path)
                if number >> bound:
                    raise CdrError(path, f"{number} has more than {bound} bits")
            case SequenceDescriptor(element, bound):
                count = self._count(_least(element), bound, path)
                self._repeat(element, count, path)
            case ArrayDescriptor(element, dimensions):
                self._repeat(element, prod(dimensions), path)
            case MapDescriptor(key, item, bound):
                for index in range(self._count(1, bound, path)):
                    self.value(key, f"{path}[{index}]")
                    self.value(item, f"{path}[{index}]")
            case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
                for field in fields:
                    self.value(field.type, f"{path}.{field.name}")
            case UnionDescriptor(switch=switch):
                branch = descriptor.branch(self.value(switch, f"{path}.discriminator"))
                if branch is not None:
                    self.value(branch.type, f"{path}.{branch.name}")
            case InterfaceDescriptor():
                self._reference(path)
        return None

    def _repeat(self, element: Descriptor, count: int, path: str) -> None:
        for index in range(count):
            self.value(element, f"{path}[{index}]")

    def _reference(self, path: str) -> None:
        self.value(_REFERENCE, path)

    def _primitive(self, name: str, path: str) -> Any:
        match name:
            case "boolean":
                octet = self._number("B", path)
                if octet > 1:
                    raise CdrError(path, f"{octet} is not a boolean")
                return bool(octet)
            case "char":
                return self._octets(1, 1, path).decode("latin-1")
            case "wchar":
                octets = self._octets(3, 1, path)
                return _converted(path, lambda: wide_character_value(octets))
            case "long double":
                octets = self._octets(16, 8, path)
                return _converted(path, lambda: quad_value(octets, self._little))
            case "Object":
                self._reference(path)
                return None
        return self._number(_CODES[name], path)


def _converted(path: str, action: Callable[[], Any]) -> Any:
    try:
        return action()
    except FAILURES as failure:
        raise CdrError(path, str(failure)) from failure


def _least(element: Descriptor) -> int:
    """The least size of an element that the codecs check a count against; 0 for none."""
    match element:
        case PrimitiveDescriptor("wchar"):
            return 3
        case PrimitiveDescriptor("long double"):
            return 16
        case PrimitiveDescriptor(name) if name in _CODES:
            return struct.calcsize(f"<{_CODES[name]}")
        case FixedDescriptor(digits=digits):
            return digits // 2 + 1
        case ArrayDescriptor(element=inner, dimensions=dimensions):
            return _least(inner) * prod(dimensions)
        case StructDescriptor(members=members):
            return sum(_least(member.type) for member in members)
        case AliasDescriptor(target=target):
            return _least(target)
        case LinkDescriptor() | PrimitiveDescriptor("char"):
            return 1
        case PrimitiveDescriptor() | InterfaceDescriptor():
            return 8
        case FlagsDescriptor(bound=bound) | BitsetDescriptor(bound=bound):
            return next(n for n in (1, 2, 4, 8) if bound <= 8 * n)
        case UnionDescriptor(switch=switch):
            return _least(switch)
    return 4
