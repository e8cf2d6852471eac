"""XCDR codecs of strings, sequences, arrays and maps (DDS-XTypes 1.3, 7.4.3.5)."""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from struct import Struct
from typing import Any

from rtgen.runtime.cdr_values import exact, flat, nested, text_octets, text_value
from rtgen.runtime.descriptors import (
    ArrayDescriptor,
    Descriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    plain,
)
from rtgen.runtime.faults import LOCATED
from rtgen.runtime.marshalling.shapes import SHAPES_KEPT
from rtgen.runtime.xcdr_codecs import (
    PADDING,
    Codec,
    Format,
    Octets,
    Read,
    Run,
    Write,
    left,
    refuse,
)

EMPTY_ELEMENTS = 65536
"""The largest number of elements without octets in a collection."""

_DUAL_USE = {1: 5, 4: 6, 8: 7}
"""The length code that uses the count as the length, by the size of a primitive element."""

Of = Callable[[Descriptor], Codec]


def delimited(
    format_: Format, write_inner: Write, read_inner: Read
) -> tuple[Write, Read]:
    """Writer and reader of content after a DHEADER, which bounds the input of `read_inner`."""
    ulong = Struct(f"{format_.order}I")
    pack_into, unpack = ulong.pack_into, ulong.unpack_from
    zero = bytes(4)

    def write(out: bytearray, value: Any) -> None:
        out += PADDING[len(out) & 3]
        out += zero
        start = len(out)
        write_inner(out, value)
        pack_into(out, start - 4, len(out) - start)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        offset += -offset & 3
        (size,) = unpack(data, offset)
        offset += 4
        left(data, offset, size)
        end = offset + size
        value, used = read_inner(memoryview(data)[offset:end], 0)
        if used != size:
            raise ValueError(f"{size - used} octets too many")
        return value, end

    return write, read


def string_codec(format_: Format, descriptor: StringDescriptor) -> Codec:
    """`string` is UTF-8 that ends with NUL; `wstring` UTF-16 in octets, without mark and NUL."""
    ulong = Struct(f"{format_.order}I")
    pack, unpack = ulong.pack, ulong.unpack_from
    bound = descriptor.bound
    wide = descriptor.wide
    encoding = "utf-16-le" if format_.little else "utf-16-be"

    def checked(length: int) -> None:
        if bound is not None and length > bound:
            unit = "UTF-16 units" if wide else "octets of UTF-8"
            raise ValueError(f"{length} {unit}, and {bound} are the most")

    def write_narrow(out: bytearray, value: Any) -> None:
        octets = text_octets(value)
        if bound is not None:
            checked(len(octets))
        out += PADDING[len(out) & 3]
        out += pack(len(octets) + 1)
        out += octets
        out += b"\0"

    def write_wide(out: bytearray, value: Any) -> None:
        if "\0" in value:
            raise ValueError("a wstring cannot hold NUL")
        octets = value.encode(encoding)
        checked(len(octets) // 2)
        out += PADDING[len(out) & 3]
        out += pack(len(octets))
        out += octets

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        offset += -offset & 3
        (size,) = unpack(data, offset)
        offset += 4
        left(data, offset, size)
        end = offset + size
        if not wide:
            if bound is not None:
                checked(size - 1)
            return text_value(bytes(data[offset:end])), end
        checked(size // 2)
        text = str(data[offset:end], encoding)
        if "\0" in text:
            raise ValueError("a wstring cannot hold NUL")
        return text, end

    return Codec(write_wide if wide else write_narrow, read, 4, 5)


def sequence_codec(format_: Format, descriptor: SequenceDescriptor, of: Of) -> Codec:
    """A count and the elements, after a DHEADER in version 2 if they are not primitive."""
    element = of(descriptor.element)
    write_items, read_items = _items(format_, descriptor.element, element)
    bound = descriptor.bound
    ulong = Struct(f"{format_.order}I")
    pack, unpack = ulong.pack, ulong.unpack_from
    least = element.least

    def write(out: bytearray, value: Any) -> None:
        count = len(value)
        if bound is not None and count > bound:
            raise ValueError(f"{count} items, and {bound} are the most")
        out += PADDING[len(out) & 3]
        out += pack(count)
        if count:
            write_items(out, value)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        offset += -offset & 3
        (count,) = unpack(data, offset)
        offset += 4
        _check_count(data, offset, count, least, bound)
        return read_items(data, offset, count)

    if format_.version == 1 or element.primitive:
        run = element.run
        code = _DUAL_USE.get(run.least, 4) if run is not None else 4
        return Codec(write, read, 4, code)
    return Codec(*delimited(format_, write, read), 8, 5)


def array_codec(
    format_: Format, descriptor: ArrayDescriptor, of: Of, inner: bool = False
) -> Codec:
    """The elements, after a DHEADER in version 2 if they are not primitive.

    An array of an alias of an array (`inner`) has more dimensions, and no second DHEADER.
    """
    dimensions = descriptor.dimensions
    if len(dimensions) > 1 and _is_text(descriptor.element):
        row = ArrayDescriptor(descriptor.element, dimensions[-1:])
        rows = ArrayDescriptor(row, dimensions[:-1])
        return array_codec(format_, rows, of, inner)
    target = plain(descriptor.element)
    if isinstance(target, ArrayDescriptor):
        element = array_codec(format_, target, of, True)
    else:
        element = of(descriptor.element)
    several = len(dimensions) > 1
    write_items, read_items = _items(format_, descriptor.element, element)
    total = prod(dimensions)
    least = total * element.least

    def write(out: bytearray, value: Any) -> None:
        if several:
            value = flat(value, dimensions)
        write_items(out, exact(value, total))

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        left(data, offset, least)
        value, offset = read_items(data, offset, total)
        return (nested(value, dimensions) if several else value), offset

    if format_.version == 1 or element.primitive or inner:
        return Codec(write, read, least, 4, element.primitive and inner)
    return Codec(*delimited(format_, write, read), 4 + least, 5)


def map_codec(format_: Format, descriptor: MapDescriptor, of: Of) -> Codec:
    """A count and the pairs, after a DHEADER in version 2 if not both are primitive."""
    key, item = of(descriptor.key), of(descriptor.value)
    bound = descriptor.bound
    ulong = Struct(f"{format_.order}I")
    pack, unpack = ulong.pack, ulong.unpack_from
    write_key, write_item = key.write, item.write
    read_key, read_item = key.read, item.read
    least = key.least + item.least

    def write(out: bytearray, value: Any) -> None:
        if bound is not None and len(value) > bound:
            raise ValueError(f"{len(value)} items, and {bound} are the most")
        out += PADDING[len(out) & 3]
        out += pack(len(value))
        for k, v in value.items():
            write_key(out, k)
            write_item(out, v)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        offset += -offset & 3
        (count,) = unpack(data, offset)
        offset += 4
        _check_count(data, offset, count, least, bound)
        value: dict[Any, Any] = {}
        index = 0
        try:
            for index in range(count):  # noqa: B007
                k, offset = read_key(data, offset)
                value[k], offset = read_item(data, offset)
        except LOCATED as failure:
            refuse(failure, f"[{index}]")
        return value, offset

    if format_.version == 1 or (key.primitive and item.primitive):
        return Codec(write, read, 4)
    return Codec(*delimited(format_, write, read), 8)


def _check_count(
    data: Octets, offset: int, count: int, least: int, bound: int | None
) -> None:
    rest = len(data) - offset
    if count * least > rest or (not least and count > EMPTY_ELEMENTS):
        raise ValueError(f"a length of {count}, and {rest} octets are left")
    if bound is not None and count > bound:
        raise ValueError(f"{count} items, and {bound} are the most")


_ReadItems = Callable[[Octets, int, int], tuple[Any, int]]


def _is_text(descriptor: Descriptor) -> bool:
    """Whether a collection of that type is `bytes` or `str`."""
    target = plain(descriptor)
    texts = ("octet", "uint8", "char")
    return isinstance(target, PrimitiveDescriptor) and target.name in texts


def _items(
    format_: Format, descriptor: Descriptor, element: Codec
) -> tuple[Write, _ReadItems]:
    """Writer and reader of a number of elements."""
    if _is_text(descriptor):
        if plain(descriptor) == PrimitiveDescriptor("char"):
            return _write_characters, _read_characters
        return _write_octets, _read_octets
    if element.run is not None and element.run.paths == ("",):
        return _scalars(format_, element.run)
    write_one, read_one = element.write, element.read

    def write(out: bytearray, value: Any) -> None:
        for item in value:
            write_one(out, item)

    if element.run is not None and element.run.build is not None:
        return write, element.run.many(element.run.build)

    def read(data: Octets, offset: int, count: int) -> tuple[Any, int]:
        items: list[Any] = []
        try:
            for _ in range(count):
                item, offset = read_one(data, offset)
                items.append(item)
        except LOCATED as failure:
            refuse(failure, f"[{len(items)}]")
        return items, offset

    return write, read


class _Shapes(dict[int, Struct]):
    """Cache of `Struct`s by count, cleared when full."""

    def __init__(self, order: str, code: str) -> None:
        self._order = order
        self._code = code

    def __missing__(self, count: int) -> Struct:
        if len(self) >= SHAPES_KEPT:
            self.clear()
        simple = len(self._code) == 1
        text = f"{count}{self._code}" if simple else self._code * count
        made = self[count] = Struct(self._order + text)
        return made


def _scalars(format_: Format, run: Run) -> tuple[Write, _ReadItems]:
    """Writer and reader of scalars in one `struct` call."""
    (scalar,) = run.scalars
    order, code, size = format_.order, scalar.code, scalar.size
    mask = min(scalar.align, format_.widest) - 1
    encode, decode = scalar.encode, scalar.decode
    shapes = _Shapes(order, code)

    def write(out: bytearray, value: Any) -> None:
        padding = -len(out) & mask
        if padding:
            out += bytes(padding)
        if encode is not None:
            value = [encode(item) for item in value]
        out += shapes[len(value)].pack(*value)

    def read(data: Octets, offset: int, count: int) -> tuple[Any, int]:
        if count:
            offset += -offset & mask
        left(data, offset, count * size)
        values = list(shapes[count].unpack_from(data, offset))
        if decode is not None:
            index = 0
            try:
                for index, item in enumerate(values):
                    values[index] = decode(item)
            except LOCATED as failure:
                refuse(failure, f"[{index}]")
        return values, offset + count * size

    return write, read


def _write_octets(out: bytearray, value: Any) -> None:
    if not isinstance(value, bytes | bytearray):
        raise TypeError("bytes are needed")
    out += value


def _read_octets(data: Octets, offset: int, count: int) -> tuple[Any, int]:
    end = offset + count
    return bytes(data[offset:end]), end


def _write_characters(out: bytearray, value: Any) -> None:
    out += value.encode("latin-1")


def _read_characters(data: Octets, offset: int, count: int) -> tuple[Any, int]:
    end = offset + count
    return str(data[offset:end], "latin-1"), end
