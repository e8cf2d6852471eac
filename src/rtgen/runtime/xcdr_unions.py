"""XCDR codecs of unions (DDS-XTypes 1.3, 7.4.3.5)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rtgen.runtime.descriptors import UnionDescriptor
from rtgen.runtime.faults import LOCATED, Fault
from rtgen.runtime.xcdr_codecs import (
    Codec,
    Format,
    Octets,
    Read,
    UnsupportedError,
    Write,
    refuse,
)
from rtgen.runtime.xcdr_collections import Of, delimited
from rtgen.runtime.xcdr_initial import initial_value
from rtgen.runtime.xcdr_members import Parameter, list_reader, parameter_writers
from rtgen.runtime.xcdr_structs import listed

DISCRIMINATOR = "discriminator"
DISCRIMINATOR_ID = 0

_Select = Callable[[Any], "int | None"]


def union_codec(format_: Format, descriptor: UnionDescriptor, of: Of) -> Codec:
    """The codec of a union by its extensibility."""
    switch = of(descriptor.switch)
    codecs = []
    for branch in descriptor.branches:
        try:
            codecs.append(of(branch.type))
        except UnsupportedError as failure:
            failure.path = f".{branch.name}{failure.path}"
            raise
    if descriptor.extensibility == "mutable" and not format_.key:
        return _mutable(format_, descriptor, switch, codecs)
    write = _plain_writer(descriptor, switch, codecs)
    delimiting = format_.version == 2 and not format_.key
    if descriptor.extensibility == "appendable" and delimiting:
        read = _plain_reader(descriptor, switch, codecs, True)
        return Codec(*delimited(format_, write, read), 4)
    return Codec(write, _plain_reader(descriptor, switch, codecs, False), switch.least)


def _selection(descriptor: UnionDescriptor) -> _Select:
    """The function that finds the number of the branch that a discriminator selects."""
    labels = {
        label: index
        for index, branch in enumerate(descriptor.branches)
        for label in branch.labels
    }
    others = [i for i, branch in enumerate(descriptor.branches) if branch.default]
    other = others[0] if others else None
    return lambda discriminator: labels.get(discriminator, other)


def _refuse_value(value: Any) -> None:
    if value is not None:
        raise ValueError("no branch is selected")


def _plain_writer(
    descriptor: UnionDescriptor, switch: Codec, codecs: Sequence[Codec]
) -> Write:
    select = _selection(descriptor)
    write_switch = switch.write
    writes = [codec.write for codec in codecs]

    def write(out: bytearray, value: Any) -> None:
        discriminator = value.discriminator
        write_switch(out, discriminator)
        index = select(discriminator)
        if index is None:
            _refuse_value(value.value)
        else:
            writes[index](out, value.value)

    return write


def _plain_reader(
    descriptor: UnionDescriptor, switch: Codec, codecs: Sequence[Codec], to_end: bool
) -> Read:
    """`to_end`: later octets are ignored, and a branch without octets has its default."""
    select = _selection(descriptor)
    read_switch = switch.read
    reads = [codec.read for codec in codecs]
    names = [f".{branch.name}" for branch in descriptor.branches]
    class_ = descriptor.class_
    initial = [partial(initial_value, b.type) for b in descriptor.branches]

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        name = f".{DISCRIMINATOR}"
        value = None
        try:
            discriminator, offset = read_switch(data, offset)
            index = select(discriminator)
            if index is not None:
                name = names[index]
                if to_end and offset >= len(data):
                    value = initial[index]()
                else:
                    value, offset = reads[index](data, offset)
        except LOCATED as failure:
            refuse(failure, name)
        return class_(discriminator, value), len(data) if to_end else offset

    return read


def _mutable(
    format_: Format,
    descriptor: UnionDescriptor,
    switch: Codec,
    codecs: Sequence[Codec],
) -> Codec:
    """A list of one parameter for the discriminator and one for the value."""
    first = Parameter(DISCRIMINATOR, DISCRIMINATOR_ID, False, False, True, switch)
    parameters = [
        Parameter(branch.attribute, branch.id, False, False, False, codec)
        for branch, codec in zip(descriptor.branches, codecs, strict=True)
    ]
    select = _selection(descriptor)
    write_switch, *writes = parameter_writers(format_, [first, *parameters])
    read_list = list_reader(format_, [first, *parameters])
    class_ = descriptor.class_
    initial = [partial(initial_value, b.type) for b in descriptor.branches]

    def write(out: bytearray, value: Any) -> None:
        discriminator = value.discriminator
        write_switch(out, discriminator)
        index = select(discriminator)
        if index is None:
            _refuse_value(value.value)
        else:
            writes[index](out, value.value)

    def read(data: Octets, offset: int) -> tuple[Any, int]:
        values, offset = read_list(data, offset)
        if DISCRIMINATOR not in values:
            raise Fault("the discriminator is missing")
        discriminator = values[DISCRIMINATOR]
        index = select(discriminator)
        if index is None:
            return class_(discriminator, None), offset
        name = parameters[index].name
        value = values[name] if name in values else initial[index]()
        return class_(discriminator, value), offset

    return Codec(*listed(format_, write, read), 4)
