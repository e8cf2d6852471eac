"""CANopen data types (CiA 301, 7.1.6) to IDL types and RTC data ports.

Sources: Table 4 of the published description of RTC-CANopen (`TABLE_4`); other types map to the
next wider IDL type, since IDL 3 has no others (`WIDER`), or to raw octets (`OCTETS`).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rtgen.compiler.model import (
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.compiler.model.canopen import SIGNED, UNSIGNED, DataType


class Source(StrEnum):
    """Source of a row."""

    TABLE_4 = "RTC-CANopen, Table 4"
    WIDER = "next wider type"
    OCTETS = "raw octets"
    TIME = "time of RTC"


@dataclass(frozen=True, slots=True)
class Row:
    """The IDL type of a data type. `timed` is the RTC type of a port with this type only."""

    type: Type
    timed: str | None
    source: Source


def _primitive(kind: Primitive, timed: str | None, source: Source) -> Row:
    return Row(PrimitiveType(kind), timed, source)


_SHORT = Primitive.SHORT
_LONG, _ULONG = Primitive.LONG, Primitive.UNSIGNED_LONG
_LONG_LONG, _ULONG_LONG = Primitive.LONG_LONG, Primitive.UNSIGNED_LONG_LONG
_OCTET_SEQUENCE = SequenceType(PrimitiveType(Primitive.OCTET))
_RAW = Row(_OCTET_SEQUENCE, "TimedOctetSeq", Source.OCTETS)
_TIME = Row(NamedType(("RTC", "Time")), None, Source.TIME)

ROWS = {
    DataType.BOOLEAN: _primitive(Primitive.BOOLEAN, "TimedBoolean", Source.TABLE_4),
    DataType.UNSIGNED8: _primitive(Primitive.OCTET, "TimedOctet", Source.TABLE_4),
    DataType.VISIBLE_CHAR: _primitive(Primitive.CHAR, "TimedChar", Source.TABLE_4),
    DataType.INTEGER8: _primitive(_SHORT, "TimedShort", Source.WIDER),
    DataType.INTEGER16: _primitive(_SHORT, "TimedShort", Source.TABLE_4),
    DataType.UNSIGNED16: _primitive(
        Primitive.UNSIGNED_SHORT, "TimedUShort", Source.TABLE_4
    ),
    DataType.INTEGER24: _primitive(_LONG, "TimedLong", Source.WIDER),
    DataType.UNSIGNED24: _primitive(_ULONG, "TimedULong", Source.WIDER),
    DataType.INTEGER32: _primitive(_LONG, "TimedLong", Source.TABLE_4),
    DataType.UNSIGNED32: _primitive(_ULONG, "TimedULong", Source.TABLE_4),
    DataType.INTEGER40: _primitive(_LONG_LONG, None, Source.WIDER),
    DataType.INTEGER48: _primitive(_LONG_LONG, None, Source.WIDER),
    DataType.INTEGER56: _primitive(_LONG_LONG, None, Source.WIDER),
    DataType.INTEGER64: _primitive(_LONG_LONG, None, Source.WIDER),
    DataType.UNSIGNED40: _primitive(_ULONG_LONG, None, Source.WIDER),
    DataType.UNSIGNED48: _primitive(_ULONG_LONG, None, Source.WIDER),
    DataType.UNSIGNED56: _primitive(_ULONG_LONG, None, Source.WIDER),
    DataType.UNSIGNED64: _primitive(_ULONG_LONG, None, Source.TABLE_4),
    DataType.REAL32: _primitive(Primitive.FLOAT, "TimedFloat", Source.TABLE_4),
    DataType.REAL64: _primitive(Primitive.DOUBLE, "TimedDouble", Source.TABLE_4),
    DataType.VISIBLE_STRING: Row(StringType(), "TimedString", Source.TABLE_4),
    DataType.UNICODE_STRING: Row(StringType(wide=True), "TimedWString", Source.TABLE_4),
    DataType.OCTET_STRING: _RAW,
    DataType.DOMAIN: _RAW,
    DataType.TIME_OF_DAY: _TIME,
    DataType.TIME_DIFFERENCE: _TIME,
}


def row(data_type: int) -> Row:
    """Return the row of a data type; unknown types are raw octets."""
    try:
        return ROWS[DataType(data_type)]
    except ValueError:
        return _RAW


def limits(data_type: int) -> tuple[int, int] | None:
    """Return the range of an integer type whose IDL type has a wider range."""
    if row(data_type).source is not Source.WIDER:
        return None
    code = DataType(data_type)
    if code in SIGNED:
        half = 1 << SIGNED[code] - 1
        return (-half, half - 1) if SIGNED[code] < 64 else None
    return 0, (1 << UNSIGNED[code]) - 1
