"""The checks that change PDOs: mapping, transmission types, times (CiA 301, 7.5.2.35 to 38).

Reset communication reverts the changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from rtgen.compiler.model.canopen import Pdo, PdoDirection, PdoEntry
from rtgen.facts.canopen import INVALID, MAX_SYNC_CYCLIC
from rtgen.runtime.canopen.description import ObjectNumber
from rtgen.runtime.canopen.values import size
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import (
    MAX_DATA,
    MILLISECOND,
    CobId,
    Frame,
)
from rtgen.runtime.canopen.wire.pdo_transmission import (
    EVENT_PROFILE,
    RTR,
    RTR_SYNC,
    SYNC_ACYCLIC,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.tools.can.decoding.node_index import DescribedObject
from rtgen.tools.conformance.canopen.node import NodeUnderTest, refusal
from rtgen.tools.conformance.check import ACTUATE, Problems, check

_COB_ID, _TYPE, _INHIBIT, _EVENT_TIMER = 1, 2, 3, 5
_MAX_ENTRIES: Final = 64
"""Entries of a mapping; higher counts are those of multiplexed PDOs."""
_RESERVED: Final = (MAX_SYNC_CYCLIC + 1, RTR_SYNC - 1)
_CYCLES: Final = (1, 3, MAX_SYNC_CYCLIC)
"""Tested transmission types of PDOs that follow SYNC."""
_SYNC_PERIOD: Final = MILLISECOND
"""Minimum time between two SYNCs."""
_REPEATED: Final = 3
"""Number of equal PDOs of type 0 after which they count as cyclic."""
_INHIBIT_UNIT: Final = MILLISECOND // 10
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

    @property
    def is_sent(self) -> bool:
        """Whether it is a TPDO that maps objects: without any, none is sent."""
        is_tpdo = self.pdo.direction is PdoDirection.TPDO
        return is_tpdo and bool(present_entries(self.node, self.pdo))

    @property
    def inhibit_time(self) -> int:
        """Its inhibit time in ns; 0 if it has none."""
        number = self.pdo.communication, _INHIBIT
        if number not in self.node.values:
            return 0
        return int.from_bytes(self.node.upload(number), "little") * _INHIBIT_UNIT

    def can_set(self, subindex: int, *values: int) -> bool:
        """Return whether a communication parameter is described as writable, with these values."""
        number = self.pdo.communication, subindex
        return _is_writable(self.node, number) and all(
            self.node.allows(number, value) for value in values
        )

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
                if CobId(cob_id).valid:
                    yield ChangedPdo(node, pdo, cob_id)
    finally:
        node.restart()


@check(
    "pdo.mapping",
    "mappings are set, and invalid ones are refused",
    "CiA 301, 7.5.2.36",
    ACTUATE,
)
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
            locked = node.write_code(places[0], bytes(4)) is not None
            problem = f"{each.name}: an entry can be changed while sub-index 0 is not 0"
            yield None if locked else problem
            if not locked:
                _mapped(node, pdo, entries)


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


@check(
    "pdo.content",
    "TPDOs have the values of their objects",
    "CiA 301, 7.5.2.38",
    ACTUATE,
)
def content(node: NodeUnderTest) -> Problems:
    """Check that TPDOs have the values of the mapped objects, with one mapped object, too."""
    for each in _changed(node, _COB_ID, _TYPE):
        mapped = whole_objects(node, each.pdo)
        if each.pdo.direction is not PdoDirection.TPDO or not mapped:
            continue
        if not each.take_type(1):
            continue
        yield _carried(each, mapped)
        count = each.pdo.mapping, 0
        if len(mapped) > 1 and _is_writable(node, count):
            with each.invalid():
                node.download(count, b"\1")
            yield _carried(each, mapped[:1])
            yield from _written(each)


def _written(each: ChangedPdo) -> Problems:
    """Check a TPDO that maps a writable object, with the lowest bit of its value changed."""
    node = each.node
    for thing in node.described.objects.values():
        variable = node.described.device.find(*thing.number)
        before = node.values.get(thing.number, b"")
        if variable is None or not variable.pdo_mappable or len(before) < 2:
            continue
        if not thing.access.writable or size(thing.kind) != len(before):
            continue
        index, sub = thing.number
        with each.invalid():
            entry = index << 16 | sub << 8 | 8 * len(before)
            if _mapped(node, each.pdo, [entry]) is not None:
                continue
        node.download(thing.number, bytes((before[0] ^ 1,)) + before[1:])
        try:
            yield _carried(each, [thing])
        finally:
            node.download(thing.number, before)
        return


def _carried(each: ChangedPdo, mapped: list[DescribedObject]) -> str | None:
    """Return a problem unless a TPDO of type 1 has the values of these objects."""
    node = each.node
    with node.operational():
        before = [node.upload(thing.number) for thing in mapped]
        node.synchronise()
        frame = node.await_frame(each.can_id, node.bounds.answer)
        after = [node.upload(thing.number) for thing in mapped]
    if frame is None:
        return f"{each.name}: not sent after a SYNC"
    expected = b"".join(after)
    # Values that change meanwhile are not compared, only their length.
    fits = (
        frame.data == expected if before == after else len(frame.data) == len(expected)
    )
    problem = f"{each.name} has {frame.data.hex()}, its objects have {expected.hex()}"
    return None if fits else problem


@check(
    "pdo.identifiers",
    "identifiers of valid PDOs cannot be changed",
    "CiA 301, 7.5.2.37",
    ACTUATE,
)
def identifiers(node: NodeUnderTest) -> Problems:
    for each in _changed(node, _COB_ID):
        number = each.pdo.communication, _COB_ID
        other = (each.cob_id ^ 1).to_bytes(4, "little")
        refused = node.write_code(number, other) is not None
        problem = f"{each.name}: the identifier was changed while the PDO is valid"
        yield None if refused else problem


@check(
    "pdo.transmission", "each transmission type of TPDOs", "CiA 301, 7.5.2.37", ACTUATE
)
def transmission(node: NodeUnderTest) -> Problems:
    """Check that TPDOs are sent by their transmission type, and reserved types are rejected."""
    for each in _changed(node, _COB_ID, _TYPE):
        with each.invalid():
            own = node.upload((each.pdo.communication, _TYPE))
            for kind in _RESERVED:
                code = each.set(_TYPE, kind)
                yield refusal(f"{each.name}: type {kind}", code, sdo.VALUE_INVALID)
            accepted = node.write_code((each.pdo.communication, _TYPE), own) is None
            problem = f"{each.name}: its own type {own[0]} is refused"
            yield None if accepted else problem
        if not each.is_sent:
            continue
        cyclic = False
        for kind in _CYCLES:
            if each.take_type(kind):
                cyclic = kind > 1
                yield _cyclic(each, kind)
            elif cyclic:
                yield f"{each.name}: type {kind} is refused, but lower ones are not"
        if each.take_type(SYNC_ACYCLIC):
            yield _acyclic(each)
        if node.line.remote_frames and not CobId(each.cob_id).bit30:
            for kind in (RTR_SYNC, RTR):
                if each.take_type(kind):
                    yield _remote(each, kind)


def _cyclic(each: ChangedPdo, kind: int) -> str | None:
    node = each.node
    with node.operational():
        counted, cycles = 0, 2 if kind <= _SENT else 1
        for place in range(1, cycles * kind + 1):
            node.synchronise()
            within = max(_QUIET // kind, _SYNC_PERIOD) if place % kind else _QUIET
            counted += node.await_frame(each.can_id, within) is not None
    problem = f"{each.name}, type {kind}: {counted} after {cycles * kind} SYNCs"
    return None if counted == cycles else problem


def _acyclic(each: ChangedPdo) -> str | None:
    node, sent = each.node, list[bytes]()
    with node.operational():
        if node.await_frame(each.can_id, _QUIET) is not None:
            return f"{each.name}, type 0: sent without SYNC"
        for _ in range(_REPEATED):
            node.synchronise()
            frame = node.await_frame(each.can_id, _QUIET)
            sent += [] if frame is None else [frame.data]
    cyclic = len(sent) == _REPEATED and len(set(sent)) == 1
    return (
        f"{each.name}, type 0: sent at each SYNC without a change" if cyclic else None
    )


def _remote(each: ChangedPdo, kind: int) -> str | None:
    node = each.node
    with node.operational():
        for _ in range(2):
            node.synchronise()
        if node.await_frame(each.can_id, _QUIET) is not None:
            return f"{each.name}, type {kind}: sent without a remote frame"
        node.line.send(Frame(each.can_id, remote=True))
        frame = node.await_frame(each.can_id, node.bounds.answer)
    problem = f"{each.name}, type {kind}: no answer to a remote frame"
    return None if frame is not None else problem


@check("pdo.times", "event timers and inhibit times", "CiA 301, 7.5.2.37", ACTUATE)
def times(node: NodeUnderTest) -> Problems:
    """Check that the event timer of a TPDO is its period, and the inhibit time the minimum."""
    for each in _changed(node, _COB_ID, _TYPE, _EVENT_TIMER):
        if not each.is_sent or not each.can_set(_EVENT_TIMER, _PERIOD):
            continue
        if not each.take_type(EVENT_PROFILE):
            continue
        with each.invalid():
            each.set(_EVENT_TIMER, _PERIOD)
            # A node may have one that is longer than the event timer.
            if each.can_set(_INHIBIT, 0):
                each.set(_INHIBIT, 0)
        if each.inhibit_time > _PERIOD * MILLISECOND:
            continue
        yield _spaced(each, "event timer")
        if each.can_set(_INHIBIT, 10 * _PERIOD) and each.can_set(
            _EVENT_TIMER, _PERIOD // 5
        ):
            with each.invalid():
                each.set(_EVENT_TIMER, _PERIOD // 5)
                each.set(_INHIBIT, 10 * _PERIOD)
            yield _spaced(each, "inhibit time", later=_PERIOD // 5)


def _spaced(each: ChangedPdo, what: str, *, later: int = 0) -> str | None:
    """Return a problem unless PDOs are sent with the period, or up to `later` ms after it."""
    node, times = each.node, list[int]()
    with node.operational():
        while len(times) <= _SENT:
            if node.await_frame(each.can_id, 10 * _PERIOD * MILLISECOND) is None:
                return f"{each.name}: {len(times)} PDOs with an {what} of {_PERIOD} ms"
            times.append(node.line.now())
    # The PDO sent at the start of the node does not come from the timer.
    mean = (times[-1] - times[1]) / (_SENT - 1) / MILLISECOND
    tolerance = node.bounds.period_tolerance * _PERIOD
    fits = _PERIOD - tolerance <= mean <= _PERIOD + later + tolerance
    problem = f"{each.name}: PDOs each {mean:.0f} ms with an {what} of {_PERIOD} ms"
    return None if fits else problem


@check(
    "pdo.synchronous-reception",
    "synchronous RPDOs take effect at a SYNC",
    "CiA 301, 7.5.2.35",
    ACTUATE,
)
def synchronous_reception(node: NodeUnderTest) -> Problems:
    """Check that the data of a synchronous RPDO are in its objects from the next SYNC on."""
    for each in _changed(node, _COB_ID, _TYPE):
        mapped = whole_objects(node, each.pdo)
        if each.pdo.direction is not PdoDirection.RPDO or not mapped:
            continue
        if not each.take_type(SYNC_ACYCLIC):
            continue
        with node.operational():
            before = [node.upload(thing.number) for thing in mapped]
            other = [bytes((value[0] ^ 1,)) + value[1:] for value in before]
            held = before
            for values in (other, before):
                node.line.send(Frame(each.can_id, b"".join(values)))
                now = node.values_later(mapped)
                yield None if now == held else f"{each.name}: taken before a SYNC"
                node.synchronise()
                now = node.values_soon(mapped, values)
                yield None if now == values else f"{each.name}: not taken at a SYNC"
                held = values


def present_entries(node: NodeUnderTest, pdo: Pdo) -> tuple[PdoEntry, ...]:
    """Return the mapping that the node has; a DCF may describe one that is not yet written."""
    count = node.values.get((pdo.mapping, 0))
    if not count or count[0] > _MAX_ENTRIES:
        return pdo.entries
    read = (node.values.get((pdo.mapping, k), b"") for k in range(1, count[0] + 1))
    codes = [int.from_bytes(octets, "little") for octets in read]
    return tuple(PdoEntry(c >> 16, c >> 8 & 0xFF, c & 0xFF) for c in codes)


def whole_objects(node: NodeUnderTest, pdo: Pdo) -> list[DescribedObject]:
    """Return the objects that a PDO maps, if it maps known ones with all their octets."""
    objects = []
    for entry in present_entries(node, pdo):
        thing = node.described.objects.get((entry.index, entry.subindex))
        octets = b"" if thing is None else node.values.get(thing.number, b"")
        if thing is None or 8 * len(octets) != entry.bits:
            return []
        objects.append(thing)
    return objects
