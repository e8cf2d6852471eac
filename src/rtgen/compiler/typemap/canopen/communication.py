"""Data types of communication objects (CiA 301, 7.5.2), as a fallback for files without them."""

from __future__ import annotations

from rtgen.compiler.model.canopen import DataType

_U8, _U16, _U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32

_OBJECTS = {
    **dict.fromkeys((0x1008, 0x1009, 0x100A), DataType.VISIBLE_STRING),
    **dict.fromkeys((0x1001, 0x100D, 0x1019, 0x1029), _U8),
    **dict.fromkeys((0x100C, 0x1015, 0x1017), _U16),
    **dict.fromkeys((0x1000, *range(0x1002, 0x1004), *range(0x1005, 0x1008)), _U32),
    **dict.fromkeys((*range(0x1010, 0x1015), 0x1016, 0x1018, 0x1020, 0x1028), _U32),
    0x1021: DataType.DOMAIN,
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
