"""Which lines of an EDS strict readers refuse, and how these are written for them.

Readers differ: Lely's dcfgen refuses a file with a key that CiA 306 does not have, a value outside
of the limits for a node-id, a mapping of an object that does not exist, or a real number that is
not given by its bits; other readers ignore these lines. So they are comments, with a mark by which
rtgen reads them.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from rtgen.compiler.model.canopen import (
    BITS,
    MAPPINGS,
    SIGNED,
    UNSIGNED,
    DataType,
    Device,
    NodeRelative,
    Object,
    Value,
    Variable,
)
from rtgen.compiler.typemap.canopen.communication import type_of

MARK: Final = "; rtgen: "
"""The mark of a line in a comment."""

_OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?")
_PLAIN = ("FileInfo", "DeviceInfo", "DeviceComissioning", "DummyUsage", "Comments")
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
_RATE = re.compile(r"BaudRate_(?!(?:10|20|50|125|250|500|800|1000)$)")
_NOT_OF_OBJECTS = ("Unit", "Factor", "Description")
_REALS: Mapping[int, tuple[str, str]] = {
    DataType.REAL32: ("<f", "<I"),
    DataType.REAL64: ("<d", "<Q"),
}
_FIRST_OBJECT = 0x1000
_PROFILE_AREA = 0x2000
_KNOWN = frozenset(map(int, DataType))
_LIMITS = dict.fromkeys(("LowLimit", "HighLimit"), "")
_VALUES = _LIMITS | dict.fromkeys(("DefaultValue", "ParameterValue"), "")
_NODES = 127
_STRUCTURE = 0xFF
"""The sub-index of an object's structure (CiA 301, 7.4.3)."""


class Portable:
    """Decides for each line of a device's file."""

    def __init__(self, device: Device) -> None:
        self._objects = {thing.index: thing for thing in device.objects}
        self._device = device

    def lines(self, name: str, pairs: Sequence[tuple[str, str]]) -> Iterator[str]:
        """Yield the lines of a section."""
        if name in LISTS:
            yield from self._list(name, pairs)
            return
        match = _OBJECT.fullmatch(name)
        is_kept = match is None and name not in _PLAIN
        if match is not None:
            sub = int(match[2] or "0", 16)
            is_kept = sub == _STRUCTURE or self._is_empty(int(match[1], 16))
        yield f"{MARK if is_kept else ''}[{name}]"
        hidden = self._hidden(match)
        for key, value in pairs:
            line = f"{key}={value}"
            if is_kept or key in hidden or _RATE.match(key):
                written = hidden.get(key, "")
                if written and not is_kept:
                    yield f"{key}={written}"
                yield MARK + line
            else:
                yield line

    def _is_empty(self, index: int) -> bool:
        return not self._objects[index].variables

    def _list(self, name: str, pairs: Sequence[tuple[str, str]]) -> Iterator[str]:
        """Yield a list of objects, those without a variable at its end."""
        (count, total), *entries = pairs
        indices = sorted((text for _, text in entries), key=self._order)
        empty = sum(self._is_empty(int(text, 16)) for text in indices)
        yield f"[{name}]"
        yield f"{count}={len(indices) - empty}"
        if empty:
            yield f"{MARK}{count}={total}"
        for number, text in enumerate(indices, 1):
            is_empty = self._is_empty(int(text, 16))
            yield f"{MARK if is_empty else ''}{number}={text}"

    def _order(self, text: str) -> tuple[bool, int]:
        index = int(text, 16)
        return self._is_empty(index), index

    def _hidden(self, match: re.Match[str] | None) -> dict[str, str]:
        """Return the hidden keys of an object, with the values that are written beside."""
        if match is None:
            return {}
        index = int(match[1], 16)
        thing = self._objects[index]
        hidden = dict.fromkeys(_NOT_OF_OBJECTS, "")
        if match[2] is None and len(thing.variables) != 1:
            hidden |= self._count(thing)
        variable = self._device.find(index, int(match[2] or "0", 16))
        if variable is not None:
            hidden |= _values(variable)
            type_ = _standard_type(variable, is_sub=match[2] is not None)
            if type_ not in (None, variable.data_type):
                is_count = type_ == DataType.UNSIGNED8 and _fits(
                    variable.default, 0, 0xFF
                )
                hidden |= _LIMITS if is_count else _VALUES
                hidden["DataType"] = f"0x{type_:04X}"
            if match[2] is not None and index in MAPPINGS:
                hidden |= self._mapped(variable)
        return hidden

    def _mapped(self, variable: Variable) -> dict[str, str]:
        """Return the values of an entry of a mapping whose object does not exist."""
        values = {"DefaultValue": variable.default, "ParameterValue": variable.value}
        wrong = {
            key: "0x0"
            for key, value in values.items()
            if variable.subindex and isinstance(value, int) and not self._exists(value)
        }
        return _LIMITS | wrong if wrong else {}

    def _exists(self, entry: int) -> bool:
        index, subindex = entry >> 16, entry >> 8 & 0xFF
        if index < _FIRST_OBJECT:
            return not entry or (index in BITS and not subindex)
        return self._device.find(index, subindex) is not None

    @staticmethod
    def _count(thing: Object) -> dict[str, str]:
        subs = [v for v in thing.variables if v.subindex != _STRUCTURE]
        return (
            {"SubNumber": f"0x{len(subs):X}"}
            if len(subs) != len(thing.variables)
            else {}
        )


def _values(variable: Variable) -> dict[str, str]:
    """Return the keys of values and limits that are hidden."""
    values = {"DefaultValue": variable.default, "ParameterValue": variable.value}
    code = variable.data_type
    if code in _REALS:
        return _LIMITS | {
            key: bits_text(value, code)
            for key, value in values.items()
            if isinstance(value, float) and value
        }
    low, high = _range(code)
    if low is None or high is None:
        return _LIMITS
    hidden = {k: "" for k, v in values.items() if not _fits(v, low, high)}
    ends = (variable.low, variable.high)
    if any(isinstance(end, NodeRelative) for end in ends):
        return _LIMITS | hidden
    inner = [low if ends[0] is None else ends[0], high if ends[1] is None else ends[1]]
    shown = [v for k, v in values.items() if k not in hidden]
    if not all(_fits(value, *map(int, inner)) for value in shown):  # type: ignore[arg-type]
        hidden |= _LIMITS
    return hidden


def _standard_type(variable: Variable, *, is_sub: bool) -> int | None:
    """Return the data type that CiA 301 has for a variable, if its own cannot be read as that."""
    code, index = variable.data_type, variable.index
    if is_sub and not variable.subindex:
        return DataType.UNSIGNED8
    if index < _PROFILE_AREA and code not in _KNOWN:
        return type_of(index, variable.subindex)
    return None


def _range(code: int) -> tuple[int | None, int | None]:
    if code in SIGNED:
        return -(1 << SIGNED[DataType(code)] - 1), (1 << SIGNED[DataType(code)] - 1) - 1
    if code in UNSIGNED:
        return 0, (1 << UNSIGNED[DataType(code)]) - 1
    return (0, 1) if code == DataType.BOOLEAN else (None, None)


def _fits(value: Value | None, low: int, high: int) -> bool:
    """Return whether a value is within limits, for each node-id."""
    if isinstance(value, NodeRelative):
        return max(low - 1, 0) <= value.offset <= high - _NODES
    return (
        low <= value <= high if isinstance(value, int) else not isinstance(value, float)
    )


def bits_text(value: float, code: int) -> str:
    """Return a real number by its bits."""
    real, bits = _REALS[code]
    [number] = struct.unpack(bits, struct.pack(real, value))
    return f"0x{number:X}"
