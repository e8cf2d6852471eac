"""XCDR, the data representations of DDS: bodies, and payloads with encapsulation header.

DDS-XTypes 1.3, 7.4 and 7.6.3.1. Codecs are compiled from a type's descriptor, once for each version
and byte order. Version 1 is PLAIN_CDR, with PL_CDR for mutable types; version 2 is PLAIN_CDR2,
DELIMITED_CDR and PL_CDR2, depending on the extensibility of each type.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any, TypeVar

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.marshalling.errors import Buffer, CdrError
from rtgen.runtime.marshalling.layouts.envelopes import identifier
from rtgen.runtime.marshalling.layouts.formats import Format

_T = TypeVar("_T", bound=DataType)


class Representation(IntEnum):
    """The encapsulation identifiers of DDSI-RTPS 2.5, 10.2 and DDS-XTypes 1.3, table 60."""

    CDR_BE = 0x00
    CDR_LE = 0x01
    PL_CDR_BE = 0x02
    PL_CDR_LE = 0x03
    CDR2_BE = 0x06
    CDR2_LE = 0x07
    D_CDR2_BE = 0x08
    D_CDR2_LE = 0x09
    PL_CDR2_BE = 0x0A
    PL_CDR2_LE = 0x0B

    @property
    def version(self) -> int:
        """The version of XCDR, 1 or 2."""
        return 1 if self < Representation.CDR2_BE else 2

    @property
    def little_endian(self) -> bool:
        """Whether the least significant octet comes first."""
        return bool(self & 1)


def representation_of(
    type_: type[DataType], version: int = 2, little_endian: bool = True
) -> Representation:
    """Return the representation of a type's values in a version of XCDR and a byte order."""
    return Representation(identifier(type_._descriptor_, version, little_endian))


def serialize(value: DataType, representation: Representation) -> bytes:
    """Return the payload of a value: header, body, and padding to a multiple of 4 octets.

    Raises CdrError, also if the extensibility of the type requires another representation.
    """
    type_ = type(value)
    _check_kind(type_, representation)
    version = Format(representation.version)
    function = compiled("to_payload", type_._descriptor_, version)
    payload: bytes = function(value, representation.little_endian)
    return payload


def deserialize(type_: type[_T], payload: Buffer) -> _T:
    """Return the value of a payload; raises CdrError."""
    octets = payload if payload.__class__ is bytes else _octets(type_, payload)
    chosen = type_._descriptor_.codecs.get(octets[:4])
    function, little_endian, end = chosen or _decoder(type_, octets[:4])
    value: _T = function(type_, octets[4:end], little_endian)
    return value


def _decoder(
    type_: type[DataType], head: bytes
) -> tuple[Callable[..., Any], bool, int | None]:
    """Return the decoder of bodies after this header, the byte order and the end of the body.

    Raises CdrError. Of the options of a header, two bits are the number of octets of padding.
    """
    if len(head) < 4:
        raise CdrError(_name(type_), "the encapsulation header is truncated")
    number = int.from_bytes(head[:2], "big")
    try:
        representation = Representation(number)
    except ValueError:
        message = f"{number:#06x} is not an encapsulation of XCDR"
        raise CdrError(_name(type_), message) from None
    _check_kind(type_, representation)
    format_ = Format(representation.version)
    function = compiled("from_cdr", type_._descriptor_, format_)
    padding = head[3] & 3
    chosen = function, representation.little_endian, -padding or None
    if head[2:] == bytes((0, padding)):
        type_._descriptor_.codecs[head] = chosen
    return chosen


def _check_kind(type_: type[DataType], representation: Representation) -> None:
    expected = representation_of(
        type_, representation.version, representation.little_endian
    )
    if expected is not representation:
        message = f"its representation is {expected.name}, not {representation.name}"
        raise CdrError(_name(type_), message)


def encode(type_: Any, value: object, version: int, little_endian: bool) -> bytes:
    """Return the body of a value of a generated type or typedef; raises CdrError."""
    function = compiled("to_cdr", type_._descriptor_, Format(version))
    body: bytes = function(value, little_endian)
    return body


def decode(type_: Any, data: Buffer, version: int, little_endian: bool) -> Any:
    """Return the value of a body; raises CdrError."""
    function = compiled("from_cdr", type_._descriptor_, Format(version))
    return function(type_, data, little_endian)


def _name(type_: Any) -> str:
    return str(type_._descriptor_.name).rpartition("::")[2]


def _octets(type_: Any, data: Buffer) -> bytes:
    try:
        return bytes(memoryview(data))
    except TypeError as failure:
        message = f"octets are needed, not {type(data).__name__}"
        raise CdrError(_name(type_), message) from failure
