"""Members with a header of their own: of mutable types, and optional ones.

DDS-XTypes 1.3: 7.4.3.4.2 (EMHEADER), 7.4.1.2 (parameters of XCDR1). Written as Cyclone DDS 11
does: parameters of XCDR1 in the extended form, those of mutable types padded to 4 octets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from struct import Struct
from typing import Any

from rtgen.runtime.descriptors import MemberDescriptor
from rtgen.runtime.faults import LOCATED, Fault, located
from rtgen.runtime.xcdr_codecs import (
    PADDING,
    Codec,
    Format,
    Octets,
    Write,
    left,
    refuse,
)

PID_EXTENDED = 0x3F01
PID_LIST_END = 0x3F02
PID_IGNORE = 0x3F03
SHORT_MUST_UNDERSTAND = 0x4000
SHORT_IMPLEMENTATION = 0x8000
LONG_MUST_UNDERSTAND = 0x40000000
LONG_IMPLEMENTATION = 0x80000000
MUST_UNDERSTAND = 0x80000000
MEMBER_ID = 0x0FFFFFFF


@dataclass(frozen=True, slots=True)
class Parameter:
    """A member of a mutable type."""

    name: str
    id: int
    must_understand: bool
    optional: bool
    key: bool
    codec: Codec


@dataclass(frozen=True, slots=True)
class _Found:
    """A parameter in the input: its content, and where the next one may start."""

    id: int
    must_understand: bool
    content: Octets
    end: int


def optional_codec(format_: Format, member: MemberDescriptor, codec: Codec) -> Codec:
    """An optional member of a final or appendable struct; None is absent."""
    if format_.version == 2:
        return _flagged(codec)
    write_one = _parameter_writer(
        format_, member.id, member.must_understand, codec, False
    )
    write_none = _parameter_header(format_, member.id, member.must_understand, 0)
    next_parameter = _parameters(format_)

    def write(out: bytearray, value: Any) -> None:
        if value is None:
            out += PADDING[len(out) & 3]
            out += write_none
        else:
            write_one(out, value)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        found = next_parameter(data, offset)
        if found is None or found.id != member.id:
            raise ValueError(f"the parameter {member.id} is needed")
        if not found.content:
            return None, found.end
        return _whole(codec, found.content, 0), found.end

    return Codec(write, read, 4)


def _flagged(codec: Codec) -> Codec:
    write_one, read_one = codec.write, codec.read

    def write(out: bytearray, value: Any) -> None:
        if value is None:
            out += b"\0"
        else:
            out += b"\1"
            write_one(out, value)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        left(data, offset, 1)
        present = data[offset]
        if present > 1:
            raise ValueError(f"{present} is not a boolean")
        return read_one(data, offset + 1) if present else (None, offset + 1)

    return Codec(write, read, 1)


def _whole(codec: Codec, content: Octets, padding: int) -> Any:
    """The value that fills the content, except for at most that much padding."""
    value, used = codec.read(content, 0)
    if len(content) - used > padding:
        raise ValueError(f"{len(content) - used} octets too many")
    return value


def parameter_writers(format_: Format, parameters: Sequence[Parameter]) -> list[Write]:
    """The functions that write each parameter, header and value."""
    make = _member_writer if format_.version == 2 else _padded_writer
    return [make(format_, p.id, p.must_understand, p.codec) for p in parameters]


def _member_writer(
    format_: Format, id_: int, must_understand: bool, codec: Codec
) -> Write:
    ulong = Struct(f"{format_.order}I")
    pack_into = ulong.pack_into
    flag = MUST_UNDERSTAND if must_understand else 0
    header = ulong.pack(flag | codec.length_code << 28 | id_)
    write_value = codec.write

    def write(out: bytearray, value: Any) -> None:
        out += PADDING[len(out) & 3]
        out += header
        write_value(out, value)

    if codec.length_code != 4:
        return write
    zero = bytes(4)

    def write_sized(out: bytearray, value: Any) -> None:
        out += PADDING[len(out) & 3]
        out += header
        out += zero
        start = len(out)
        write_value(out, value)
        pack_into(out, start - 4, len(out) - start)

    return write_sized


def _parameter_header(
    format_: Format, id_: int, must_understand: bool, size: int
) -> bytes:
    flag = LONG_MUST_UNDERSTAND if must_understand else 0
    pid = PID_EXTENDED | SHORT_MUST_UNDERSTAND
    return Struct(f"{format_.order}HHII").pack(pid, 8, flag | id_, size)


def _padded_writer(
    format_: Format, id_: int, must_understand: bool, codec: Codec
) -> Write:
    return _parameter_writer(format_, id_, must_understand, codec, True)


def _parameter_writer(
    format_: Format, id_: int, must_understand: bool, codec: Codec, padded: bool
) -> Write:
    header = _parameter_header(format_, id_, must_understand, 0)[:8]
    pack = Struct(f"{format_.order}I").pack
    write_value = codec.write

    def write(out: bytearray, value: Any) -> None:
        content = bytearray()
        write_value(content, value)
        if padded:
            content += PADDING[len(content) & 3]
        out += PADDING[len(out) & 3]
        out += header
        out += pack(len(content))
        out += content

    return write


def list_end(format_: Format) -> bytes:
    """The parameter that ends a list of XCDR1."""
    return Struct(f"{format_.order}HH").pack(PID_LIST_END | SHORT_MUST_UNDERSTAND, 0)


_Next = Callable[[Octets, int], "_Found | None"]


def _parameters(format_: Format) -> _Next:
    """The function that finds the parameter at an offset in a list of XCDR1; None at its end."""
    short, long = Struct(f"{format_.order}HH"), Struct(f"{format_.order}II")

    def next_parameter(data: Octets, offset: int) -> _Found | None:
        offset += -offset & 3
        pid, size = short.unpack_from(data, offset)
        offset += 4
        masked = pid & ~SHORT_MUST_UNDERSTAND
        must_understand = bool(pid & SHORT_MUST_UNDERSTAND)
        if masked == PID_LIST_END:
            return None
        if masked == PID_EXTENDED:
            if size != 8:
                raise ValueError(f"an extended parameter header of {size} octets")
            flags, size = long.unpack_from(data, offset)
            offset += 8
            must_understand = bool(flags & LONG_MUST_UNDERSTAND)
            masked = flags & (MEMBER_ID | LONG_IMPLEMENTATION)
        elif masked == PID_IGNORE:
            masked = LONG_IMPLEMENTATION
        elif masked & SHORT_IMPLEMENTATION:
            masked = masked & ~SHORT_IMPLEMENTATION | LONG_IMPLEMENTATION
        left(data, offset, size)
        end = offset + size
        return _Found(masked, must_understand, memoryview(data)[offset:end], end)

    return next_parameter


def _members(format_: Format) -> _Next:
    """The function that finds the member at an offset after a DHEADER; None at the end."""
    ulong = Struct(f"{format_.order}I")

    def next_member(data: Octets, offset: int) -> _Found | None:
        if offset >= len(data):
            return None
        offset += -offset & 3
        (header,) = ulong.unpack_from(data, offset)
        offset += 4
        code = header >> 28 & 7
        if code < 4:
            size = 1 << code
        else:
            (size,) = ulong.unpack_from(data, offset)
            if code == 4:
                offset += 4
            else:
                size = 4 + size * (1, 4, 8)[code - 5]
        left(data, offset, size)
        end = offset + size
        must_understand = bool(header & MUST_UNDERSTAND)
        return _Found(
            header & MEMBER_ID, must_understand, memoryview(data)[offset:end], end
        )

    return next_member


def list_reader(
    format_: Format, parameters: Sequence[Parameter]
) -> Callable[[Octets, int], tuple[dict[str, Any], int]]:
    """The function that reads a list to the values by name and the offset after it.

    Unknown parameters are skipped unless they are marked must-understand.
    """
    known = {p.id: (p.name, p.codec) for p in parameters}
    next_one = _members(format_) if format_.version == 2 else _parameters(format_)
    padding = 0 if format_.version == 2 else 3
    end_size = 0 if format_.version == 2 else 4

    def read(data: Octets, offset: int) -> tuple[dict[str, Any], int]:
        values: dict[str, Any] = {}
        while (found := next_one(data, offset)) is not None:
            offset = found.end
            member = known.get(found.id)
            if member is None:
                if found.must_understand:
                    raise Fault(f"the unknown member {found.id} has to be understood")
                continue
            name, codec = member
            if name in values:
                raise located(Fault("the member stands twice"), f".{name}")
            try:
                values[name] = _whole(codec, found.content, padding)
            except LOCATED as failure:
                refuse(failure, f".{name}")
        return values, offset + (-offset & 3) + end_size if end_size else offset

    return read
