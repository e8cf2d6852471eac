"""Describes a node from what it answers by SDO; what the node does not tell is a marked guess."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator
from itertools import groupby
from typing import Final

import msgspec

from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.canopen import (
    BITS,
    UNSIGNED,
    Access,
    DataType,
    Device,
    DeviceInfo,
    FileInfo,
    NodeRelative,
    Object,
    ObjectType,
    Value,
    Variable,
)
from rtgen.facts.canopen import (
    EXTENDED,
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    TPDO_MAPPING,
    visible_text,
)
from rtgen.facts.cob_ids import service_of
from rtgen.runtime.canopen.wire import sdo
from rtgen.tools.can.live.dictionary_reading import Number, Reading
from rtgen.tools.can.live.standard_objects import ARRAYS, name_of, standard

_NO_SPAN: Final = Span("", 1, 1, 1, 1)
_UNSIGNED: Final = {bits: type_ for type_, bits in UNSIGNED.items()}
_TEXT_FROM: Final = 5
"""Octets from which a printable value is a text; 3 are, too: few devices have 24-bit numbers."""
_PLAIN_TEXT: Final = re.compile(r"[\w.,:+/()\-]+(?: [\w.,:+/()\-]+)*", re.ASCII)
"""Texts that are a default value as they are."""
_VOLATILE: Final = (0x1001, 0x1002, 0x1003, 0x1010, 0x1011, 0x1013)
"""Communication objects whose value is not a setting."""
_ERRORS: Final = 0x1003
_PLAUSIBLE: Final = (1e-4, 1e7)
"""Range of the magnitudes of what may be a real."""
_HIGHEST: Final = "Highest sub-index supported"
_LISTED: Final = 64
"""Refused objects listed in the file; the rest is counted."""


class ObjectRow(msgspec.Struct, frozen=True):
    """A line of the table: an object, its type and access, and what of it is a guess."""

    number: str
    name: str
    data_type: str
    access: str
    guess: str


class NodeDescription(msgspec.Struct, frozen=True):
    """The text of an EDS, its objects, and what the node refuses, with the reasons."""

    text: str
    rows: tuple[ObjectRow, ...]
    refused: tuple[str, ...]


def describe(reading: Reading, node_id: int, file_name: str) -> NodeDescription:
    """Return the description of a node."""
    builder = _Builder(reading, node_id)
    objects = tuple(builder.objects())
    device = builder.device(objects, file_name)
    header = [
        f"Read from node {node_id} by rtgen can scan.",
        "Names of standardized objects are those of CiA 301, 401 and 402. Lines with `guess:` mark",
        "what a node does not tell: nothing has been written, and a type is known by its length.",
    ]
    if reading.stopped:
        header.insert(0, f"PARTIAL: {reading.stopped}; further objects are missing.")
    described = {v.number for thing in objects for v in thing.variables}
    refused = tuple(_refused(reading, described))
    header += [f"Not described: {line}" for line in refused[:_LISTED]]
    if len(refused) > _LISTED:
        header.append(f"Not described: {len(refused) - _LISTED} more")
    remarks = {
        _section(thing, variable): f"guess: {builder.guesses[number]}"
        for thing in objects
        for variable in thing.variables
        if builder.guesses.get(number := variable.number)
    }
    rows = tuple(
        ObjectRow(
            _written(v.number),
            v.name,
            "DOMAIN" if v.domain else v.type_name,
            v.access.value,
            builder.guesses.get(v.number, ""),
        )
        for thing in objects
        for v in thing.variables
    )
    return NodeDescription(eds_text(device, header, remarks), rows, refused)


def _section(thing: Object, variable: Variable) -> str:
    if thing.type in (ObjectType.VAR, ObjectType.DOMAIN):
        return f"{variable.index:04X}"
    return f"{variable.index:04X}sub{variable.subindex:X}"


def _written(number: Number) -> str:
    index, subindex = number
    return f"{index:04X}:{subindex}" if subindex else f"{index:04X}"


def _refused(reading: Reading, described: set[Number]) -> Iterator[str]:
    """Yield the objects that the node refuses, and that are not described, with the reasons."""
    for number, code in sorted(reading.refusals.items()):
        if number not in described:
            yield f"{_written(number)}: {code:08X}h {sdo.ABORT_TEXTS.get(code, '')}".rstrip()
    for number in reading.silent:
        yield f"{_written(number)}: no answer"


class _Builder:
    """Makes objects of values; `guesses` has what is not certain, by index and sub-index."""

    def __init__(self, reading: Reading, node_id: int) -> None:
        self._reading = reading
        self._node_id = node_id
        self.guesses: dict[Number, str] = {}
        self._sent: dict[Number, int] = {}
        self._received: dict[Number, int] = {}
        for sent, number, bits in reading.mapped():
            (self._sent if sent else self._received)[number] = bits

    def objects(self) -> Iterator[Object]:
        """Yield the objects by index."""
        reading, mapped = self._reading, self._sent | self._received
        write_only = {n for n, c in reading.refusals.items() if c == sdo.WRITE_ONLY}
        refused = {n for n in reading.refusals if n in mapped}
        refused |= {
            (index, subindex)
            for (index, subindex), code in reading.refusals.items()
            if code == sdo.NO_DATA and index == _ERRORS and (index, 0) in reading.values
        }
        numbers = sorted({*reading.values, *reading.long, *write_only, *refused})
        for index, group in groupby(numbers, key=lambda number: number[0]):
            subs = [subindex for _, subindex in group]
            if index == _ERRORS and subs == [0]:
                # Some nodes have no subobjects as long as there is no error.
                subs.append(1)
            name = name_of(index, reading.profile) or f"Object {index:04X}h"
            if subs == [0]:
                variable = self._variable((index, 0), name)
                type_ = ObjectType.DOMAIN if variable.domain else ObjectType.VAR
                yield Object(
                    index=index,
                    name=name,
                    type=type_,
                    variables=(variable,),
                    span=_NO_SPAN,
                )
                continue
            variables = [
                self._variable((index, s), self._part(index, s, name))
                for s in subs
                if s
            ]
            variables.insert(0, self._count(index, subs[-1]))
            yield Object(
                index=index,
                name=name,
                type=_kind(variables),
                variables=tuple(variables),
                span=_NO_SPAN,
            )

    def device(self, objects: tuple[Object, ...], file_name: str) -> Device:
        """Return the device of the objects."""
        values = self._reading.values
        identity = [
            int.from_bytes(octets, "little") if octets else None
            for octets in (values.get((0x1018, part)) for part in (1, 2, 3))
        ]
        indices = {thing.index for thing in objects}
        counts = [
            sum(base <= index < base + PDOS for index in indices)
            for base in (RPDO_COMMUNICATION, TPDO_COMMUNICATION)
        ]
        name = _text(values.get((0x1008, 0), b""))
        info = DeviceInfo(
            vendor_name="unknown",
            product_name=name or "unknown",
            vendor_number=identity[0],
            product_number=identity[1],
            revision_number=identity[2],
            boot_up_slave=True,
            granularity=8,
            rpdos=counts[0],
            tpdos=counts[1],
        )
        file_info = FileInfo(
            file_name=file_name,
            version=1,
            revision=0,
            eds_version="4.0",
            description=f"Read from node {self._node_id}",
            created_by="rtgen can scan",
        )
        dummies = {n[0] for n in (*self._sent, *self._received) if 0 < n[0] < 0x20}
        return Device(
            name="",
            file="",
            key="",
            sha256="",
            span=_NO_SPAN,
            node_id=None,
            file_info=file_info,
            info=info,
            commissioning=None,
            objects=objects,
            pdos=(),
            dummies=tuple(sorted(dummies)),
        )

    def _part(self, index: int, subindex: int, name: str) -> str:
        known = standard(index, subindex, self._reading.profile).name
        return known if known and known != name else f"{name} {subindex}"

    def _count(self, index: int, highest: int) -> Variable:
        octets = self._reading.values.get((index, 0))
        if octets is None:
            self.guesses[index, 0] = f"the node has no {index:04X}:0"
        count = highest if octets is None else octets[0]
        mapping = any(b <= index < b + PDOS for b in (RPDO_MAPPING, TPDO_MAPPING))
        access = Access.RW if mapping or index == _ERRORS else Access.RO
        return _variable(
            (index, 0), _HIGHEST, DataType.UNSIGNED8, access, default=count
        )

    def _variable(self, number: Number, name: str) -> Variable:
        octets = self._reading.values.get(number)
        known = standard(*number, self._reading.profile)
        bits = self._sent.get(number, self._received.get(number))
        guesses = []
        if octets is None and known.data_type is not None:
            type_, guess = known.data_type, ""
        elif octets is None:
            type_, guess = self._unread(number, bits)
        elif known.data_type is not None and _fits(known.data_type, octets, bits):
            type_, guess = known.data_type, ""
        else:
            type_, guess = _type(octets, bits)
        guesses += [f"type {guess}"] if guess else []
        access, guess = self._access(number, known.access)
        guesses += [f"access {guess}"] if guess else []
        default, guess = self._default(number, type_)
        guesses += [guess] if guess else []
        if guesses:
            self.guesses[number] = "; ".join(guesses)
        return _variable(
            number,
            name,
            type_,
            access,
            default=default,
            mapped=bits is not None,
        )

    def _unread(self, number: Number, bits: int | None) -> tuple[DataType, str]:
        """Return the type of an object whose value is not known."""
        if bits in _UNSIGNED or bits == 1:
            return _of_bits(bits), f"by its {bits} bits in a PDO"
        if number in self._reading.long:
            return DataType.DOMAIN, "by its length"
        return DataType.DOMAIN, "not known, the node does not let it be read"

    def _access(self, number: Number, known: Access | None) -> tuple[Access, str]:
        """Return the access, which mappings and the standard tell, and what of it is a guess."""
        sent, received = number in self._sent, number in self._received
        code = self._reading.refusals.get(number)
        if code in (sdo.WRITE_ONLY, sdo.ACCESS_UNSUPPORTED):
            if sent:
                return Access.RO, "by its mapping, the node does not let it be read"
            return Access.WO, ""
        agrees = known is not None and (
            (known.in_tpdo or not sent) and (known.in_rpdo or not received)
        )
        if known is not None and agrees:
            return known, ""
        if received:
            return Access.RW, ""
        if sent:
            return Access.RO, "by its mapping, it may be writable"
        return Access.RW, "it is readable, no write has been tried"

    def _default(self, number: Number, type_: DataType) -> tuple[Value | None, str]:
        """Return the default value of a communication object: its value now."""
        octets = self._reading.values.get(number)
        index = number[0]
        if octets is None or index >= 0x2000 or index in _VOLATILE:
            return None, ""
        if type_ is DataType.VISIBLE_STRING:
            return _text(octets) or None, ""
        if type_ not in UNSIGNED:
            return None, ""
        value = int.from_bytes(octets, "little")
        service = service_of(number)
        if service is None or not service.relative or service.base is None:
            return value, ""
        if value & EXTENDED or value & 0x7FF != service.base + self._node_id:
            return value, ""
        return NodeRelative(value - self._node_id), "the COB-ID follows the node-id"


def _variable(
    number: Number,
    name: str,
    type_: DataType,
    access: Access,
    *,
    default: Value | None = None,
    mapped: bool = False,
) -> Variable:
    return Variable(
        index=number[0],
        subindex=number[1],
        name=name,
        data_type=type_,
        access=access,
        written_access=access.value,
        span=_NO_SPAN,
        value_span=_NO_SPAN,
        domain=type_ is DataType.DOMAIN,
        pdo_mappable=mapped,
        default=default,
    )


def _kind(variables: list[Variable]) -> ObjectType:
    """Return ARRAY for equal members without gaps, else RECORD."""
    members = variables[1:]
    alike = len({(v.data_type, v.access) for v in members}) == 1
    whole = [v.subindex for v in variables] == list(range(len(variables)))
    index = variables[0].index
    alike &= index >= 0x2000 or index in ARRAYS
    return ObjectType.ARRAY if alike and whole else ObjectType.RECORD


def _fits(type_: DataType, octets: bytes, bits: int | None) -> bool:
    """Return whether a value can be of a type: its length, and that in a PDO."""
    width = BITS.get(type_)
    if width is None:
        return bits is None
    return len(octets) == -(-width // 8) and bits in (None, width)


def _of_bits(bits: int | None) -> DataType:
    return DataType.BOOLEAN if bits == 1 else _UNSIGNED[bits or 0]


def _type(octets: bytes, bits: int | None) -> tuple[DataType, str]:
    """Return the type of a value by its length and content, and what of it is a guess."""
    length = len(octets)
    if bits == 1 and length == 1:
        return DataType.BOOLEAN, "by its 1 bit in a PDO"
    if bits is None and _is_text(octets):
        return DataType.VISIBLE_STRING, "by its characters"
    if bits is None and _is_wide_text(octets):
        return DataType.UNICODE_STRING, "by its characters"
    if 8 * length in _UNSIGNED:
        also = "".join(f", {other}" for other in _others(octets))
        return _UNSIGNED[8 * length], f"by its {length} octets{also}"
    if not octets:
        return DataType.VISIBLE_STRING, "it is empty"
    return DataType.OCTET_STRING, f"by its {length} octets"


def _others(octets: bytes) -> Iterator[str]:
    """Yield what else a number may be."""
    length = len(octets)
    signed = int.from_bytes(octets, "little", signed=True)
    if length == 1 and signed in (0, 1):
        yield "it may be BOOLEAN"
    if signed < 0:
        yield f"it may be signed: {signed}"
    if length in (4, 8):
        (real,) = struct.unpack("<f" if length == 4 else "<d", octets)
        low, high = _PLAUSIBLE
        if math.isfinite(real) and low <= abs(real) <= high:
            yield f"it may be REAL{8 * length}: {real:.6g}"


def _is_text(octets: bytes) -> bool:
    body = octets.rstrip(b"\0")
    long = len(octets) == 3 or len(octets) >= _TEXT_FROM
    return long and bool(body) and visible_text(body).isprintable()


def _is_wide_text(octets: bytes) -> bool:
    if len(octets) < 2 * _TEXT_FROM or len(octets) % 2:
        return False
    return not any(octets[1::2]) and visible_text(octets[::2]).isprintable()


def _text(octets: bytes) -> str:
    """Return a text as a default value, empty if it cannot be written as it is."""
    text = visible_text(octets.rstrip(b"\0"))
    return text if _PLAIN_TEXT.fullmatch(text) else ""
