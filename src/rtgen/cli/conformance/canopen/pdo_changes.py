"""The checks that change PDOs: mapping, transmission types, times (CiA 301, 7.5.2.35 to 38).

Reset communication reverts the changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from rtgen.cli.can.decoding.node_index import DescribedObject
from rtgen.cli.conformance.canopen.node import NodeUnderTest, refusal
from rtgen.cli.conformance.check import Problems
from rtgen.facts.canopen import INVALID, MAX_SYNC_CYCLIC
from rtgen.model.canopen import Pdo, PdoDirection
from rtgen.runtime.canopen.description import ObjectNumber
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import (
    MAX_DATA,
    MILLISECOND,
    SYNC,
    CobId,
    Frame,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand
from rtgen.runtime.canopen.wire.pdo_transmission import (
    EVENT_PROFILE,
    RTR,
    RTR_SYNC,
    SYNC_ACYCLIC,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort

_COB_ID, _TYPE, _INHIBIT, _EVENT_TIMER = 1, 2, 3, 5
_RESERVED: Final = (MAX_SYNC_CYCLIC + 1, RTR_SYNC - 1)
_CYCLES: Final = (1, 3)
"""Tested transmission types of PDOs that follow SYNC."""
_PERIOD: Final = 50
"""Event timer and inhibit time of the checks in ms."""
_SENT: Final = 5
_QUIET: Final = 50 * MILLISECOND
"""Time-out after which a PDO counts as not sent."""
_NOTHING_THERE: Final = (0x5FFF, 0)
_DEVICE_TYPE: Final = (0x1000, 0)


@dataclass(slots=True)
class ChangedPdo:
    """A PDO whose parameters are changed while it is not valid."""

    node: NodeUnderTest
    pdo: Pdo
    cob_id: int

    @property
    def can_id(self) -> int:
        """Its identifier."""
        return CobId(self.cob_id).can_id

    @property
    def name(self) -> str:
        """The name of the PDO in messages."""
        return f"{self.pdo.direction.value}{self.pdo.number}"

    def can_set(self, subindex: int) -> bool:
        """Return whether a communication parameter is described as writable."""
        return _is_writable(self.node, (self.pdo.communication, subindex))

    def set(self, subindex: int, value: int) -> int | None:
        """Write a communication parameter; the abort code, None if it was written."""
        number = self.pdo.communication, subindex
        size = 2 if subindex in (_INHIBIT, _EVENT_TIMER) else 1
        return self.node.write_code(number, value.to_bytes(size, "little"))

    def take_type(self, kind: int) -> bool:
        """Set a transmission type; False if the node does not have it. Raises SdoAbort."""
        with self.invalid():
            code = self.set(_TYPE, kind)
        if code == sdo.VALUE_INVALID:
            return False
        if code is not None:
            raise SdoAbort(code)
        return True

    @contextmanager
    def invalid(self) -> Iterator[None]:
        """Context in which the PDO is not valid."""
        number = self.pdo.communication, _COB_ID
        self.node.download(number, (self.cob_id | INVALID).to_bytes(4, "little"))
        try:
            yield
        finally:
            self.node.download(number, self.cob_id.to_bytes(4, "little"))


def _is_writable(node: NodeUnderTest, number: ObjectNumber) -> bool:
    thing = node.described.objects.get(number)
    return thing is not None and thing.access.writable


def _changed(node: NodeUnderTest, *needed: int) -> Iterator[ChangedPdo]:
    """Yield the valid PDOs with these parameters writable, and restore each afterwards."""
    try:
        for pdo in node.described.device.pdos:
            number = pdo.communication, _COB_ID
            if all(_is_writable(node, (pdo.communication, sub)) for sub in needed):
                cob_id = int.from_bytes(node.upload(number), "little")
                if not cob_id & INVALID:
                    yield ChangedPdo(node, pdo, cob_id)
    finally:
        node.restart()


@contextmanager
def _operational(node: NodeUnderTest) -> Iterator[None]:
    node.command(NmtCommand.START)
    try:
        yield
    finally:
        node.command(NmtCommand.ENTER_PRE_OPERATIONAL)


def mapping(node: NodeUnderTest) -> Problems:
    """Check that a mapping can be set again; unmappable and too many objects are rejected."""
    for each in _changed(node, _COB_ID):
        pdo = each.pdo
        entries = [
            entry.index << 16 | entry.subindex << 8 | entry.bits
            for entry in pdo.entries
        ]
        count = pdo.mapping, 0
        places = [(pdo.mapping, place) for place in range(1, len(entries) + 1)]
        if not entries or not all(
            _is_writable(node, number) for number in (count, *places)
        ):
            continue
        with each.invalid():
            for (index, sub), bits, codes in (
                (_NOTHING_THERE, 8, (sdo.NO_OBJECT, sdo.NOT_MAPPABLE)),
                (_DEVICE_TYPE, 32, (sdo.NOT_MAPPABLE,)),
            ):
                code = _mapped(node, pdo, [index << 16 | sub << 8 | bits])
                yield refusal(f"{each.name}: {index:04X}h mapped", code, *codes)
            repeated = (entries * (8 * MAX_DATA + 1))[: _most(node, pdo)]
            if sum(entry & 0xFF for entry in repeated) > 8 * MAX_DATA:
                code = _mapped(node, pdo, repeated)
                yield refusal(f"{each.name}: over 8 octets", code, sdo.MAPPING_TOO_LONG)
            code = _mapped(node, pdo, entries)
            yield (
                None
                if code is None
                else f"{each.name}: its own mapping is refused with {code:08X}h"
            )
            now = [int.from_bytes(node.upload(place), "little") for place in places]
            same = now == entries and node.upload(count)[0] == len(entries)
            yield None if same else f"{each.name}: its mapping is another one then"


def _most(node: NodeUnderTest, pdo: Pdo) -> int:
    """Return the maximum number of entries of a mapping."""
    subs = [sub for index, sub in node.described.objects if index == pdo.mapping]
    return max(sub for sub in subs if sub <= 64)


def _mapped(node: NodeUnderTest, pdo: Pdo, entries: list[int]) -> int | None:
    """Return the abort code of setting a mapping, None if it was accepted."""
    count = pdo.mapping, 0
    node.download(count, b"\0")
    for place, entry in enumerate(entries, 1):
        code = node.write_code((pdo.mapping, place), entry.to_bytes(4, "little"))
        if code is not None:
            return code
    return node.write_code(count, bytes((len(entries),)))


def transmission(node: NodeUnderTest) -> Problems:
    """Check that TPDOs are sent by their transmission type, and reserved types are rejected."""
    for each in _changed(node, _COB_ID, _TYPE):
        with each.invalid():
            for kind in _RESERVED:
                code = each.set(_TYPE, kind)
                yield refusal(f"{each.name}: type {kind}", code, sdo.VALUE_INVALID)
        if each.pdo.direction is not PdoDirection.TPDO:
            continue
        for kind in _CYCLES:
            if each.take_type(kind):
                yield _cyclic(each, kind)
        if each.take_type(SYNC_ACYCLIC):
            with _operational(node):
                sent = node.await_frame(each.can_id, _QUIET) is not None
            yield f"{each.name}, type 0: sent without SYNC" if sent else None
        if node.line.remote_frames and not CobId(each.cob_id).bit30:
            for kind in (RTR_SYNC, RTR):
                if each.take_type(kind):
                    yield _remote(each, kind)


def _cyclic(each: ChangedPdo, kind: int) -> str | None:
    node = each.node
    with _operational(node):
        counted = 0
        for _ in range(2 * kind):
            node.line.send(Frame(SYNC))
            counted += node.await_frame(each.can_id, _QUIET) is not None
    problem = f"{each.name}, type {kind}: {counted} after {2 * kind} SYNCs"
    return None if counted == 2 else problem


def _remote(each: ChangedPdo, kind: int) -> str | None:
    node = each.node
    with _operational(node):
        for _ in range(2):
            node.line.send(Frame(SYNC))
        if node.await_frame(each.can_id, _QUIET) is not None:
            return f"{each.name}, type {kind}: sent without a remote frame"
        node.line.send(Frame(each.can_id, remote=True))
        found = node.await_frame(each.can_id, node.bounds.answer)
    problem = f"{each.name}, type {kind}: no answer to a remote frame"
    return None if found is not None else problem


def times(node: NodeUnderTest) -> Problems:
    """Check that the event timer of a TPDO is its period, and the inhibit time the minimum."""
    for each in _changed(node, _COB_ID, _TYPE, _EVENT_TIMER):
        if each.pdo.direction is not PdoDirection.TPDO:
            continue
        if not each.take_type(EVENT_PROFILE):
            continue
        with each.invalid():
            each.set(_EVENT_TIMER, _PERIOD)
        yield _spaced(each, "event timer", exactly=True)
        if each.can_set(_INHIBIT):
            with each.invalid():
                each.set(_EVENT_TIMER, _PERIOD // 5)
                each.set(_INHIBIT, 10 * _PERIOD)
            yield _spaced(each, "inhibit time", exactly=False)


def _spaced(each: ChangedPdo, what: str, *, exactly: bool) -> str | None:
    """Return a problem unless the times between PDOs are the period, or at least that."""
    node, times = each.node, list[int]()
    with _operational(node):
        while len(times) <= _SENT:
            if node.await_frame(each.can_id, 10 * _PERIOD * MILLISECOND) is None:
                return f"{each.name}: {len(times)} PDOs with an {what} of {_PERIOD} ms"
            times.append(node.line.now())
    # The PDO sent at the start of the node does not come from the timer.
    mean = (times[-1] - times[1]) / (_SENT - 1) / MILLISECOND
    tolerance = node.bounds.period_tolerance * _PERIOD
    fits = mean >= _PERIOD - tolerance and (not exactly or mean <= _PERIOD + tolerance)
    problem = f"{each.name}: PDOs each {mean:.0f} ms with an {what} of {_PERIOD} ms"
    return None if fits else problem


def synchronous_reception(node: NodeUnderTest) -> Problems:
    """Check that the data of a synchronous RPDO are in its objects from the next SYNC on."""
    for each in _changed(node, _COB_ID, _TYPE):
        mapped = whole_objects(node, each.pdo)
        if each.pdo.direction is not PdoDirection.RPDO or not mapped:
            continue
        if not each.take_type(SYNC_ACYCLIC):
            continue
        with _operational(node):
            before = [node.upload(thing.number) for thing in mapped]
            other = [bytes((value[0] ^ 1,)) + value[1:] for value in before]
            held = before
            for values in (other, before):
                node.line.send(Frame(each.can_id, b"".join(values)))
                now = [node.upload(thing.number) for thing in mapped]
                yield None if now == held else f"{each.name}: taken before a SYNC"
                node.line.send(Frame(SYNC))
                now = [node.upload(thing.number) for thing in mapped]
                yield None if now == values else f"{each.name}: not taken at a SYNC"
                held = values


def whole_objects(node: NodeUnderTest, pdo: Pdo) -> list[DescribedObject]:
    """Return the objects that a PDO maps, if it maps known ones with all their octets."""
    found = []
    for entry in pdo.entries:
        thing = node.described.objects.get((entry.index, entry.subindex))
        octets = b"" if thing is None else node.values.get(thing.number, b"")
        if thing is None or 8 * len(octets) != entry.bits:
            return []
        found.append(thing)
    return found
