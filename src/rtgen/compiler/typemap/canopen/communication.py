"""Data types of communication objects (CiA 301, 7.5.2), as a fallback for files without them."""

from __future__ import annotations

from rtgen.compiler.model.canopen import DataType

_U8, _U16, _U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
_TEXT = DataType.VISIBLE_STRING

_OBJECTS = {
    0x1000: _U32,
    0x1001: _U8,
    0x1002: _U32,
    0x1003: _U32,
    0x1005: _U32,
    0x1006: _U32,
    0x1007: _U32,
    0x1008: _TEXT,
    0x1009: _TEXT,
    0x100A: _TEXT,
    0x100C: _U16,
    0x100D: _U8,
    0x1010: _U32,
    0x1011: _U32,
    0x1012: _U32,
    0x1013: _U32,
    0x1014: _U32,
    0x1015: _U16,
    0x1016: _U32,
    0x1017: _U16,
    0x1018: _U32,
    0x1019: _U8,
    0x1020: _U32,
    0x1021: DataType.DOMAIN,
    0x1028: _U32,
    0x1029: _U8,
}
_SDO = {1: _U32, 2: _U32, 3: _U8}
_PDO = {1: _U32, 2: _U8, 3: _U16, 4: _U8, 5: _U16, 6: _U8}


def type_of(index: int, subindex: int) -> DataType | None:
    """Return a communication object's data type; None for sub-index 0 of an ARRAY or RECORD."""
    match index >> 8:
        case 0x12:
            return _SDO.get(subindex)
        case 0x14 | 0x15 | 0x18 | 0x19:
            return _PDO.get(subindex)
        case 0x16 | 0x17 | 0x1A | 0x1B:
            return _U32
    return _OBJECTS.get(index)
