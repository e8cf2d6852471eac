"""Reads the PDOs of a device from communication and mapping parameters (CiA 301, 7.5.2.35 ff.)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.eds import cob_ids
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.rules import pdos as rules
from rtgen.compiler.model.canopen import (
    BITS,
    PDOS,
    RPDO_COMMUNICATION,
    TPDO_COMMUNICATION,
    DataType,
    Device,
    DeviceInfo,
    NodeRelative,
    Object,
    Pdo,
    PdoDirection,
    PdoEntry,
    Value,
    Variable,
    cob_id_in_force,
    resolved,
)
from rtgen.facts.canopen import can_id_of
from rtgen.facts.cob_ids import service_of

MAX_BITS = 64
MAX_ENTRIES = 64

_MULTIPLEXED = (0xFE, 0xFF)
_TO_MAPPING = 0x200


class PdoReader:
    """Reads and checks the PDOs of one device.

    `accepted` are entries that may be mapped, whatever they are.
    """

    def __init__(
        self,
        objects: Sequence[Object],
        info: DeviceInfo,
        dummies: Sequence[int],
        node_id: int | None,
        findings: Findings,
        accepted: Collection[tuple[PdoDirection, PdoEntry]] = (),
    ) -> None:
        self._accepted = accepted
        self._objects = {o.index: o for o in objects}
        self._variables = {v.number: v for o in objects for v in o.variables}
        self._info = info
        self._dummies = frozenset(dummies)
        self._node_id = node_id
        self._findings = findings

    def read(self) -> tuple[Pdo, ...]:
        """Return the TPDOs, then the RPDOs, by number."""
        pdos = [
            *self._direction(PdoDirection.TPDO, TPDO_COMMUNICATION),
            *self._direction(PdoDirection.RPDO, RPDO_COMMUNICATION),
        ]
        self._check_cob_ids(pdos)
        return tuple(pdos)

    def _direction(self, direction: PdoDirection, base: int) -> Iterator[Pdo]:
        bases = (base, base + _TO_MAPPING)
        described = {i - b for b in bases for i in self._objects if 0 <= i - b < PDOS}
        for number in sorted(described):
            communication = self._objects.get(base + number)
            mapping = self._objects.get(base + _TO_MAPPING + number)
            if communication is None:
                if mapping is not None:
                    message = (
                        f"there is no communication parameter {base + number:04X}h"
                    )
                    self._findings.add(rules.HALF, mapping.span, message)
                continue
            if mapping is None:
                other = base + _TO_MAPPING + number
                message = f"there is no mapping parameter {other:04X}h"
                self._findings.add(rules.HALF, communication.span, message)
            pdo = self._pdo(direction, number + 1, communication, mapping)
            self._check(pdo, communication, mapping)
            yield pdo

    def _pdo(
        self,
        direction: PdoDirection,
        number: int,
        communication: Object,
        mapping: Object | None,
    ) -> Pdo:
        subs = {v.subindex: v.current for v in communication.variables}
        cob_id = self._cob_id(communication)
        count = None if mapping is None else self._count(mapping)
        members = () if mapping is None else mapping.variables
        return Pdo(
            direction=direction,
            number=number,
            cob_id=cob_id,
            transmission_type=_integer(subs.get(2)),
            entries=_entries({v.subindex: v.current for v in members}),
            default_entries=_entries({v.subindex: v.default for v in members}),
            span=communication.span,
            inhibit_time=_integer(subs.get(3)),
            event_timer=_integer(subs.get(5)),
            sync_start=_integer(subs.get(6)),
            multiplexed=count in _MULTIPLEXED,
        )

    def _cob_id(self, communication: Object) -> int | NodeRelative:
        """Return the COB-ID in force."""
        number = communication.index, 1
        variable = self._variables.get(number)
        cob_id = (
            cob_id_in_force(number, None, self._node_id)
            if variable is None
            else variable.in_force(self._node_id)
        )
        assert isinstance(cob_id, int | NodeRelative)
        return cob_id

    @staticmethod
    def _count(mapping: Object) -> int | None:
        first = (v.current for v in mapping.variables if v.subindex == 0)
        return _integer(next(first, None))

    def _check(self, pdo: Pdo, communication: Object, mapping: Object | None) -> None:
        self._check_communication(pdo, communication)
        if mapping is None:
            return
        used = self._check_number(mapping)
        spans = {v.subindex: v.value_span for v in mapping.variables}
        seen: set[tuple[int, int]] = set()
        for subindex, entry in enumerate(pdo.entries, 1):
            span = spans.get(subindex, mapping.span)
            self._check_entry(pdo, entry, span)
            key = (entry.index, entry.subindex)
            if key in seen and not entry.dummy:
                message = f"{_shown(entry)} is mapped twice"
                self._findings.add(rules.MAPPED_TWICE, span, message)
            seen.add(key)
        if pdo.bits > MAX_BITS:
            message = f"the {used} objects have {pdo.bits} bits; a PDO has {MAX_BITS}"
            self._findings.add(rules.TOO_LONG, mapping.span, message)

    def _check_communication(self, pdo: Pdo, communication: Object) -> None:
        subs = {v.subindex: v for v in communication.variables}
        place = {k: v.value_span for k, v in subs.items()}
        declared = pdo.transmission_type
        requested = pdo.direction is PdoDirection.TPDO and declared in (252, 253)
        if declared is not None and 240 < declared < 254 and not requested:
            message = f"{declared} is a reserved transmission type"
            self._findings.add(rules.BAD_TRANSMISSION, place[2], message)
        number = communication.index, 1
        service = service_of(number)
        assert service is not None
        span = place.get(1, communication.span)
        cob_ids.check_one(
            number, service, subs.get(1), span, self._node_id, self._findings
        )

    def _check_number(self, mapping: Object) -> int:
        subs = {v.subindex: v for v in mapping.variables}
        first = subs.get(0)
        used = self._count(mapping)
        span = mapping.span if first is None else first.value_span
        if used is None:
            message = "the number of mapped objects is not given; it is taken for 0"
            self._findings.add(rules.BAD_NUMBER, span, message)
            return 0
        if used in _MULTIPLEXED:
            message = f"{used:02X}h: multiplexed PDOs are not supported; it has no port"
            self._findings.add(rules.MULTIPLEXED, span, message)
            return used
        described = sum(k > 0 for k in subs)
        if used > MAX_ENTRIES or used > described:
            message = f"{used} mapped objects; {described} entries are described"
            self._findings.add(rules.BAD_NUMBER, span, message)
        return used

    def _check_entry(self, pdo: Pdo, entry: PdoEntry, span: Span) -> None:
        if (pdo.direction, entry) in self._accepted:
            return
        if not entry.index or not entry.bits:
            message = f"the entry {_shown(entry)} of {entry.bits} bits is empty"
            self._findings.add(rules.EMPTY_ENTRY, span, message)
            return
        unit = self._info.granularity
        if unit and entry.bits % unit:
            message = f"{entry.bits} bits do not fit a granularity of {unit}"
            self._findings.add(rules.GRANULARITY, span, message)
        if entry.dummy:
            self._check_gap(pdo, entry, span)
            return
        variable = self._variables.get((entry.index, entry.subindex))
        if variable is None:
            message = f"there is no object {_shown(entry)}"
            self._findings.add(rules.NO_OBJECT, span, message)
            return
        if variable.bits is not None and variable.bits != entry.bits:
            message = (
                f"{variable.name} has {variable.bits} bits; {entry.bits} are mapped"
            )
            self._findings.add(rules.OTHER_LENGTH, span, message)
        self._check_access(pdo, variable, span)

    def _check_access(self, pdo: Pdo, variable: Variable, span: Span) -> None:
        if not variable.pdo_mappable:
            message = f"{variable.name} has no PDOMapping=1"
            self._findings.add(rules.NOT_MAPPABLE, span, message)
        sent = pdo.direction is PdoDirection.TPDO
        if not (variable.access.in_tpdo if sent else variable.access.in_rpdo):
            kind = pdo.direction.upper()
            message = f"{variable.name} is {variable.access}: no {kind} carries it"
            self._findings.add(rules.WRONG_WAY, span, message)

    def _check_gap(self, pdo: Pdo, entry: PdoEntry, span: Span) -> None:
        wrong = None
        if pdo.direction is PdoDirection.TPDO:
            wrong = "a TPDO has no gaps"
        elif entry.index not in self._dummies:
            wrong = f"DummyUsage does not allow {entry.index:04X}h"
        elif BITS[DataType(entry.index)] != entry.bits:
            wrong = f"{DataType(entry.index).name} has not {entry.bits} bits"
        if wrong is not None:
            self._findings.add(rules.BAD_GAP, span, wrong)

    def _check_cob_ids(self, pdos: Sequence[Pdo]) -> None:
        seen: dict[Value, Pdo] = {}
        for pdo in pdos:
            if not pdo.valid:
                continue
            declared = resolved(pdo.cob_id, self._node_id)
            offset = declared.offset if isinstance(declared, NodeRelative) else declared
            assert isinstance(offset, int)
            identifier = can_id_of(offset)
            key: Value = (
                NodeRelative(identifier)
                if isinstance(declared, NodeRelative)
                else identifier
            )
            other = seen.setdefault(key, pdo)
            if other is not pdo:
                message = (
                    f"the COB-ID is that of {other.direction.upper()} {other.number}"
                )
                self._findings.add(rules.SAME_COB_ID, pdo.span, message)


def mapped_by(device: Device) -> frozenset[tuple[PdoDirection, PdoEntry]]:
    """Return the entries that a description maps by default, used and unused ones."""
    directions = {pdo.mapping: pdo.direction for pdo in device.pdos}
    return frozenset(
        (directions[variable.index], _entry(variable.default))
        for variable in device.variables
        if variable.index in directions
        and variable.subindex
        and isinstance(variable.default, int)
    )


def _entry(code: int) -> PdoEntry:
    return PdoEntry(code >> 16, code >> 8 & 0xFF, code & 0xFF)


def _integer(value: Value | None) -> int | None:
    return value if isinstance(value, int) else None


def _entries(values: Mapping[int, Value | None]) -> tuple[PdoEntry, ...]:
    """Return the mapping entries in use; none for a multiplexed PDO."""
    used = values.get(0)
    if not isinstance(used, int) or used in _MULTIPLEXED:
        return ()
    entries = []
    for subindex in range(1, min(used, MAX_ENTRIES) + 1):
        declared = values.get(subindex)
        if isinstance(declared, int):
            entries.append(_entry(declared))
    return tuple(entries)


def _shown(entry: PdoEntry) -> str:
    return f"{entry.index:04X}h sub-index {entry.subindex}"
