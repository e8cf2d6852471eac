"""PDOs that a file only counts (CompactPDO; CiA 306, 4.5.2)."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    TPDO_COMMUNICATION,
    Access,
    DataType,
    DeviceInfo,
    Object,
    ObjectType,
    Value,
    Variable,
    cob_id_in_force,
)

_U8, _U16, _U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
_COMMUNICATION = (
    (1, "COB-ID", _U32),
    (2, "Transmission type", _U8),
    (3, "Inhibit time", _U16),
    (4, "Compatibility entry", _U8),
    (5, "Event timer", _U16),
    (6, "SYNC start value", _U8),
)
_ENTRIES = 64
_EVENT_DRIVEN = 255
_NAMES = {RPDO_COMMUNICATION: "RPDO", TPDO_COMMUNICATION: "TPDO"}


def implied(info: DeviceInfo, indices: Collection[int], span: Span) -> Iterator[Object]:
    """Yield the objects of these PDOs at the lowest free indices; `indices` are the used ones."""
    if not info.compact_pdo:
        return
    for base, count in (
        (RPDO_COMMUNICATION, info.rpdos),
        (TPDO_COMMUNICATION, info.tpdos),
    ):
        free = (n for n in range(PDOS) if base + n not in indices)
        described = sum(base <= index < base + PDOS for index in indices)
        for _ in range(max(0, (count or 0) - described)):
            yield from _pdo(base, next(free), info.compact_pdo, indices, span)


def _pdo(
    base: int, number: int, subs: int, indices: Collection[int], span: Span
) -> Iterator[Object]:
    name = _NAMES[base]
    cob_id = cob_id_in_force((base + number, 1), None, None)
    defaults = {1: cob_id, 2: _EVENT_DRIVEN}
    members = [
        _variable(base + number, sub, label, type_, span, defaults.get(sub, 0))
        for sub, label, type_ in _COMMUNICATION
        if subs >> sub - 1 & 1
    ]
    label = f"{name} {number + 1} communication parameter"
    yield _object(base + number, label, members, span)
    mapping = base + 0x200 + number
    if mapping not in indices:
        entries = [
            _variable(mapping, sub, f"Mapped object {sub}", _U32, span, 0)
            for sub in range(1, _ENTRIES + 1)
        ]
        label = f"{name} {number + 1} mapping parameter"
        yield _object(mapping, label, entries, span, used=0)


def _object(
    index: int,
    name: str,
    members: list[Variable],
    span: Span,
    used: int | None = None,
) -> Object:
    highest = members[-1].subindex if members else 0
    label = (
        "Highest sub-index supported" if used is None else "Number of mapped objects"
    )
    value = highest if used is None else used
    access = Access.CONST if used is None else Access.RW
    first = _variable(index, 0, label, _U8, span, value, access)
    return Object(
        index=index,
        name=name,
        type=ObjectType.RECORD,
        variables=(first, *members),
        span=span,
    )


def _variable(
    index: int,
    subindex: int,
    name: str,
    type_: DataType,
    span: Span,
    default: Value | None,
    access: Access = Access.RW,
) -> Variable:
    return Variable(
        index=index,
        subindex=subindex,
        name=name,
        data_type=type_,
        access=access,
        written_access=access.value,
        span=span,
        value_span=span,
        default=default,
    )
