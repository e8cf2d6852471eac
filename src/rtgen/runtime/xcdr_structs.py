"""XCDR codecs of structs and exceptions (DDS-XTypes 1.3, 7.4.3.5.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, TypeAlias

from rtgen.runtime.descriptors import (
    MemberDescriptor,
    StructDescriptor,
)
from rtgen.runtime.faults import LOCATED, Fault, located
from rtgen.runtime.xcdr_codecs import (
    PADDING,
    Build,
    Codec,
    Format,
    Octets,
    Read,
    Run,
    Scalar,
    Step,
    UnsupportedError,
    Write,
    made,
    refuse,
)
from rtgen.runtime.xcdr_collections import Of, delimited
from rtgen.runtime.xcdr_members import (
    Parameter,
    list_end,
    list_reader,
    optional_codec,
    parameter_writers,
)


def struct_codec(format_: Format, descriptor: StructDescriptor, of: Of) -> Codec:
    """The codec of a struct by its extensibility."""
    class_ = descriptor.class_
    members = key_members(descriptor) if format_.key else descriptor.members
    codecs = [_member_codec(format_, descriptor, member, of) for member in members]
    pairs = list(zip(members, codecs, strict=True))
    if descriptor.extensibility == "mutable" and not format_.key:
        return _mutable(format_, descriptor, pairs)
    parts = _parts(format_, pairs)
    write = _write_parts(parts)
    if (
        descriptor.extensibility == "appendable"
        and format_.version == 2
        and not format_.key
    ):
        reader = _prefix_reader(class_, parts)
        return Codec(*delimited(format_, write, reader), 4)
    least = sum(codec.least for codec in codecs)
    if len(parts) == 1 and parts[0].run is not None:
        run = parts[0].run
        build = made(class_, run.builds)
        whole = Run(format_, run.scalars, run.paths, run.builds, run.labels, build)
        return Codec(write, _reader(class_, parts), least, run=whole)
    return Codec(write, _reader(class_, parts), least)


def open_ended(format_: Format, descriptor: StructDescriptor, of: Of) -> Read:
    """The reader of an appendable struct of XCDR1 that extends to the end of the octets."""
    pairs = [
        (member, _member_codec(format_, descriptor, member, of))
        for member in descriptor.members
    ]
    return _prefix_reader(descriptor.class_, _parts(format_, pairs))


def key_members(
    descriptor: StructDescriptor,
) -> Sequence[MemberDescriptor]:
    """The members of the key, by id: those marked, or all if none is (7.2.2.4.7)."""
    marked = [m for m in descriptor.members if m.key] or descriptor.members
    return sorted(marked, key=lambda member: member.id)


def _member_codec(
    format_: Format,
    descriptor: StructDescriptor,
    member: MemberDescriptor,
    of: Of,
) -> Codec:
    try:
        codec = of(member.type)
    except UnsupportedError as failure:
        failure.path = f".{member.name}{failure.path}"
        raise
    mutable = descriptor.extensibility == "mutable" and not format_.key
    if member.optional and not mutable:
        return optional_codec(format_, member, codec)
    return codec


_Pair: TypeAlias = tuple[MemberDescriptor, Codec]


@dataclass(frozen=True, slots=True)
class _Part:
    """A run of members, or one member that is not a run; `members` by name and reader."""

    members: list[tuple[str, Codec]]
    write: Write
    step: Step
    run: Run | None = None


def _parts(format_: Format, pairs: Sequence[_Pair]) -> list[_Part]:
    parts: list[_Part] = []
    pending: list[_Pair] = []

    def settle() -> None:
        if pending:
            run = _joined(format_, pending)
            members = [(member.name, codec) for member, codec in pending]
            parts.append(_Part(members, run.writer(), run.reader(), run))
            pending.clear()

    for member, codec in pairs:
        if codec.run is not None:
            pending.append((member, codec))
            continue
        settle()
        write = _writing(member.attribute, codec)
        parts.append(_Part([(member.name, codec)], write, _reading(codec)))
    settle()
    return parts


def _joined(format_: Format, members: Sequence[_Pair]) -> Run:
    """The runs of consecutive members merged into one."""
    scalars: list[Scalar] = []
    paths: list[str] = []
    builds: list[Build] = []
    labels: list[str] = []
    for member, codec in members:
        name = member.attribute
        run = codec.run
        assert run is not None
        scalars += run.scalars
        paths += [f"{name}.{path}" if path else name for path in run.paths]
        builds += run.builds if run.build is None else [run.build]
        labels += [f".{member.name}{label}" for label in run.labels]
    return Run(format_, scalars, paths, builds, labels)


def _writing(name: str, codec: Codec) -> Write:
    get, write = attrgetter(name), codec.write
    return lambda out, value: write(out, get(value))


def _reading(codec: Codec) -> Step:
    read = codec.read

    def step(data: Octets, offset: int, values: list[Any]) -> int:
        value, offset = read(data, offset)
        values.append(value)
        return offset

    return step


def _write_parts(parts: Sequence[_Part]) -> Write:
    writes = [part.write for part in parts]
    if len(writes) == 1:
        return writes[0]

    def write(out: bytearray, value: Any) -> None:
        for write_part in writes:
            write_part(out, value)

    return write


def _steps(parts: Sequence[_Part]) -> list[tuple[str, Step]]:
    """The steps with the path component that is added to their faults."""
    return [
        ("" if part.run is not None else f".{part.members[0][0]}", part.step)
        for part in parts
    ]


def _reader(class_: Callable[..., Any], parts: Sequence[_Part]) -> Read:
    steps = _steps(parts)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        values: list[Any] = []
        name = ""
        try:
            for name, step in steps:  # noqa: B007
                offset = step(data, offset, values)
        except LOCATED as failure:
            refuse(failure, name)
        return class_(*values), offset

    return read


def _prefix_reader(class_: Callable[..., Any], parts: Sequence[_Part]) -> Read:
    """The reader of the members present; missing ones get defaults, extra ones are ignored."""
    steps = [(part.members, part.step, part.run) for part in parts]

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        values: list[Any] = []
        name = ""
        end = len(data)
        try:
            for members, step, run in steps:
                if offset >= end:
                    break
                if run is None:
                    name = f".{members[0][0]}"
                    offset = step(data, offset, values)
                elif offset + run.size(offset) <= end:
                    name = ""
                    offset = step(data, offset, values)
                else:
                    for member, codec in members:
                        if offset >= end:
                            break
                        name = f".{member}"
                        value, offset = codec.read(data, offset)
                        values.append(value)
                    break
        except LOCATED as failure:
            refuse(failure, name)
        return class_(*values), end

    return read


def _mutable(
    format_: Format,
    descriptor: StructDescriptor,
    pairs: Sequence[tuple[MemberDescriptor, Codec]],
) -> Codec:
    """A list of parameters, written in the order of the definition, read in any order."""
    parameters = [
        Parameter(m.attribute, m.id, m.must_understand, m.optional, m.key, codec)
        for m, codec in pairs
    ]
    gets = [(attrgetter(p.name), p.optional) for p in parameters]
    writes = parameter_writers(format_, parameters)
    class_ = descriptor.class_

    def write(out: bytearray, value: Any) -> None:
        for (get, optional), write_parameter in zip(gets, writes, strict=True):
            item = get(value)
            if item is not None or not optional:
                write_parameter(out, item)

    parameter_list = list_reader(format_, parameters)
    keys = [p for p in parameters if p.key]

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        values, offset = parameter_list(data, offset)
        for parameter in keys:
            if parameter.name not in values:
                raise located(Fault("a key is missing"), f".{parameter.name}")
        return class_(**values), offset

    return Codec(*listed(format_, write, read), 4)


def listed(format_: Format, write_inner: Write, read: Read) -> tuple[Write, Read]:
    """Writer and reader of a parameter list: after a DHEADER, or in XCDR1 with a sentinel."""
    if format_.version == 2:
        return delimited(format_, write_inner, read)
    end = list_end(format_)

    def write(out: bytearray, value: Any) -> None:
        write_inner(out, value)
        out += PADDING[len(out) & 3]
        out += end

    return write, read
