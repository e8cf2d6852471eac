"""The PDOs of a device: parameters, transmission and reception (CiA 301, 7.2.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Final, TypeAlias

from rtgen.facts.canopen import INVALID, MAX_SYNC_CYCLIC
from rtgen.facts.write_order import MULTIPLEXED
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue, PdoDescription
from rtgen.runtime.canopen.node.emergency_producer import EmergencyProducer
from rtgen.runtime.canopen.node.object_dictionary import (
    DeviceDictionary,
    check_cob_id,
)
from rtgen.runtime.canopen.node.pdo_mapping import (
    MappedField,
    Mapping,
    checked_field,
    entry_of,
    own_entries,
    own_field,
)
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import (
    PDO_TOO_LONG,
    PDO_TOO_SHORT,
    RPDO_TIMEOUT,
)
from rtgen.runtime.canopen.wire.frames import CobId, Frame, earliest
from rtgen.runtime.canopen.wire.pdo_transmission import (
    EVENT_MANUFACTURER,
    EVENT_PROFILE,
    RTR_SYNC,
    PdoParameters,
    Received,
    RpdoReceiver,
    TpdoTransmitter,
)
from rtgen.runtime.canopen.wire.sdo import SdoAbort

IsEvent: TypeAlias = Callable[[bytes | None, bytes], bool]
"""Function that decides whether a change of an object from old to new octets triggers TPDOs.

The old octets are None when the node enters OPERATIONAL.
"""

_COB_ID, _TYPE, _INHIBIT, _EVENT_TIMER, _SYNC_START = 1, 2, 3, 5, 6
_LOCKED: Final = 0x06010003
"""Abort code for mapping entries while sub-index 0 is not 0."""
_LENGTH_ERRORS: Final = (PDO_TOO_SHORT, PDO_TOO_LONG)


class DevicePdo:
    """A PDO with its current parameters in the object dictionary.

    `own` are the entries that the device can map in any case: those that its description maps.
    """

    def __init__(
        self, dictionary: DeviceDictionary, pdo: PdoDescription, own: frozenset[int]
    ) -> None:
        self.description = pdo
        self.number = pdo.number
        self.mapping = Mapping()
        self.label = pdo.number.to_bytes(2, "little")
        """The PDO number, which identifies the PDO in emergency messages."""
        self.cob_id = CobId(INVALID)
        self.communication = pdo.communication_index
        self.mapped = pdo.mapping_index
        self._dictionary = dictionary
        self._own = own
        self._defaults: dict[int, int] = {}

    def load(self, node_id: int) -> None:
        """Set the PDO's parameters to the defaults of the description."""
        pdo = self.description
        self._defaults = {
            _COB_ID: pdo.cob_id_of(node_id),
            _TYPE: pdo.transmission_type,
            _INHIBIT: pdo.inhibit_time,
            _EVENT_TIMER: pdo.event_timer,
            _SYNC_START: pdo.sync_start,
        }
        for sub, value in self._defaults.items():
            if (self.communication, sub) in self._dictionary:
                self._dictionary.preset((self.communication, sub), value)
        count = self.mapped, 0
        if (
            count not in self._dictionary
            or self._dictionary.number(count) in MULTIPLEXED
        ):
            return
        self._dictionary.preset((self.mapped, 0), len(pdo.mapping))
        for place, entry in enumerate(pdo.mapping, 1):
            if (self.mapped, place) in self._dictionary:
                self._dictionary.preset((self.mapped, place), entry_of(*entry))

    def configure(self) -> PdoParameters:
        """Read the current parameters from the object dictionary."""
        self.cob_id = CobId(self._parameter(_COB_ID, INVALID))
        if (self.mapped, 0) in self._dictionary:
            count = self._dictionary.number((self.mapped, 0))
        else:
            count = len(self.description.mapping)
        try:
            self.mapping = self.planned(count)
        except SdoAbort:
            self.mapping = Mapping()
        try:
            return PdoParameters(
                cob_id=self._parameter(_COB_ID, INVALID),
                transmission_type=self._parameter(_TYPE),
                inhibit_time=self._parameter(_INHIBIT),
                event_timer=self._parameter(_EVENT_TIMER),
                sync_start=self._parameter(_SYNC_START),
            )
        except ValueError:
            return PdoParameters(cob_id=INVALID, transmission_type=EVENT_PROFILE)

    def planned(self, count: int) -> Mapping:
        """Return the mapping of the first `count` entries. Raises SdoAbort if it is invalid."""
        return Mapping([self._field(place) for place in range(1, count + 1)])

    def checked_field(self, entry: int) -> MappedField:
        """Return the field of a mapping entry. Raises SdoAbort if the device cannot map it."""
        description = self._dictionary.description
        if entry in self._own:
            return own_field(description, entry)
        return checked_field(description, self.description.direction, entry)

    def check_communication(self, subindex: int, value: int) -> None:
        """Check a write to a communication parameter. Raises SdoAbort."""
        old = self._parameter(subindex)
        if subindex == _COB_ID:
            check_cob_id(self.cob_id.value, value)
        elif subindex == _TYPE:
            received = self.description.direction == "rpdo"
            first = EVENT_MANUFACTURER if received else RTR_SYNC
            if MAX_SYNC_CYCLIC < value < first:
                raise SdoAbort(sdo.VALUE_INVALID)
        elif subindex in (_INHIBIT, _SYNC_START):
            if self.cob_id.valid and value != old:
                raise SdoAbort(sdo.VALUE_INVALID)
            if subindex == _SYNC_START and value > MAX_SYNC_CYCLIC:
                raise SdoAbort(sdo.VALUE_TOO_HIGH)

    def check_mapping(self, subindex: int, value: int) -> None:
        """Check a write to a mapping parameter. Raises SdoAbort."""
        if self.description.fixed or self.cob_id.valid:
            raise SdoAbort(sdo.ACCESS_UNSUPPORTED)
        if subindex:
            if self._dictionary.number((self.mapped, 0)):
                raise SdoAbort(_LOCKED)
            if value:
                self.checked_field(value)
            return
        if value > max(self._dictionary.subindices(self.mapped)):
            raise SdoAbort(sdo.MAPPING_TOO_LONG)
        self.planned(value)

    def _field(self, place: int) -> MappedField:
        number = self.mapped, place
        if number in self._dictionary:
            return self.checked_field(self._dictionary.number(number))
        if place <= len(self.description.mapping):
            entry = entry_of(*self.description.mapping[place - 1])
            return own_field(self._dictionary.description, entry)
        raise SdoAbort(sdo.MAPPING_TOO_LONG)

    def _parameter(self, subindex: int, absent: int = 0) -> int:
        number = self.communication, subindex
        if number in self._dictionary:
            return self._dictionary.number(number)
        return self._defaults.get(subindex, absent)


class DevicePdos:
    """All PDOs of a device.

    `received` is called with the number of each RPDO whose values have been stored, `rejected`
    before with each of its values that violates the limits of its object; `refused` counts these.
    """

    def __init__(
        self,
        dictionary: DeviceDictionary,
        errors: EmergencyProducer,
        received: Callable[[int], None],
        rejected: Callable[[int, ObjectNumber, SdoAbort], None],
    ) -> None:
        self._dictionary = dictionary
        self._errors = errors
        self._received = received
        self._rejected = rejected
        self._pdos: dict[int, DevicePdo] = {}
        """PDOs by the indices of their parameters."""
        self._receivers: dict[DevicePdo, RpdoReceiver] = {}
        self._transmitters: dict[DevicePdo, TpdoTransmitter] = {}
        self._timed_receivers: list[tuple[DevicePdo, RpdoReceiver]] = []
        self._timed_transmitters: list[tuple[DevicePdo, TpdoTransmitter]] = []
        self._synchronous_receivers: list[tuple[DevicePdo, RpdoReceiver]] = []
        self._synchronous_transmitters: list[tuple[DevicePdo, TpdoTransmitter]] = []
        self._by_id: dict[int, list[DevicePdo]] = {}
        self._carriers: dict[ObjectNumber, list[DevicePdo]] = {}
        self._is_event: dict[ObjectNumber, IsEvent] = {}
        self._sent: dict[ObjectNumber, bytes] = {}
        self._due: dict[DevicePdo, None] = {}
        self._touched: dict[DevicePdo, None] = {}
        self._running = False
        self.refused = 0
        own = own_entries(dictionary.description)
        self._all = [
            DevicePdo(dictionary, pdo, own[pdo.direction])
            for pdo in dictionary.description.pdos
        ]
        for pdo in self._all:
            self._pdos[pdo.communication] = self._pdos[pdo.mapped] = pdo
        dictionary.guard(self._pdos, self._check)

    @property
    def identifiers(self) -> frozenset[int]:
        """The CAN identifiers of all valid PDOs."""
        return frozenset(self._by_id)

    @property
    def overwritten(self) -> int:
        """Values that were replaced by newer ones during the inhibit time."""
        return sum(t.overwritten for t in self._transmitters.values())

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll`."""
        return earliest(
            *[each.deadline for _, each in self._timed_transmitters],
            *[each.deadline for _, each in self._timed_receivers],
        )

    def is_event(self, number: ObjectNumber, is_event: IsEvent) -> None:
        """Set the function that decides whether a change of an object triggers its TPDOs."""
        self._is_event[number] = is_event

    def load(self, node_id: int) -> None:
        """Reset all PDO parameters to their defaults."""
        for pdo in self._all:
            pdo.load(node_id)

    def configure(self) -> None:
        """Apply all PDO parameters."""
        self._touched = dict.fromkeys(self._all)
        self._rebuild(0)

    def start(self, now: int) -> None:
        """Enter OPERATIONAL: event-driven TPDOs are sent once."""
        self._running = True
        for receiver in self._receivers.values():
            receiver.start()
        for pdo in self._transmitters:
            self._begin(pdo, now)

    def stop(self) -> None:
        """Leave OPERATIONAL."""
        self._running = False
        self._due.clear()
        for receiver in self._receivers.values():
            receiver.stop()
        for transmitter in self._transmitters.values():
            transmitter.stop()

    def changed(self, number: ObjectNumber) -> None:
        """Process a changed object."""
        pdo = self._pdos.get(number[0])
        if pdo is not None:
            self._touched[pdo] = None
        for carrier in self._carriers.get(number, ()):
            self._note(carrier, number)

    def trigger(self, number: ObjectNumber) -> None:
        """Trigger the TPDOs that map an object."""
        if self._running:
            self._due |= dict.fromkeys(self._carriers.get(number, ()))

    def receive(self, frame: Frame, now: int) -> list[Frame]:
        """Process an RPDO or a remote frame for a TPDO; return the frames to send."""
        frames = []
        for pdo in self._by_id.get(frame.can_id, ()):
            receiver = self._receivers.get(pdo)
            if receiver is not None:
                if pdo.cob_id.carries(frame) and not frame.remote:
                    self._take(pdo, receiver.receive(frame, now))
            elif frame.remote and pdo.cob_id.carries(frame):
                self._refresh(pdo, now)
                answer = self._transmitters[pdo].remote(now)
                if answer is not None:
                    frames.append(answer)
        return frames

    def sync(self, counter: int, now: int) -> list[Frame]:
        """Process a SYNC: apply received synchronous RPDOs, then return due TPDOs."""
        for pdo, receiver in self._synchronous_receivers:
            data = receiver.sync()
            if data is not None:
                self._unpack(pdo, data)
        frames = list(self.flush(now))
        for pdo, transmitter in self._synchronous_transmitters:
            self._refresh(pdo, now)
            frame = transmitter.sync(counter, now)
            if frame is not None:
                frames.append(frame)
        return frames

    def poll(self, now: int) -> Iterator[Frame]:
        """Process timers: event timers, inhibit times, RPDO time-outs."""
        for pdo, receiver in self._timed_receivers:
            code = receiver.poll(now)
            if code:
                self._errors.add(code, pdo.label)
        for pdo, transmitter in self._timed_transmitters:
            due = transmitter.deadline
            if due is not None and due <= now:
                self._refresh(pdo, now)
                frame = transmitter.poll(now)
                if frame is not None:
                    yield frame

    def flush(self, now: int) -> Iterable[Frame]:
        """Apply changed parameters, and send the TPDOs whose objects have changed."""
        if self._touched:
            self._rebuild(now)
        return self._flushed(now) if self._due else ()

    def _flushed(self, now: int) -> Iterator[Frame]:
        while self._due:
            pdo = next(iter(self._due))
            del self._due[pdo]
            for number in pdo.mapping.numbers:
                self._sent[number] = self._dictionary.last(number)
            frame = self._transmitters[pdo].update(self._pack(pdo), now)
            if frame is not None:
                yield frame

    def _check(self, number: ObjectNumber, value: ObjectValue) -> None:
        pdo = self._pdos[number[0]]
        if number[0] == pdo.mapped:
            pdo.check_mapping(number[1], int(value))
        else:
            pdo.check_communication(number[1], int(value))

    def _rebuild(self, now: int) -> None:
        touched, self._touched = self._touched, {}
        for pdo in touched:
            parameters = pdo.configure()
            if pdo.description.direction == "rpdo":
                receiver = RpdoReceiver(parameters, pdo.mapping.size)
                self._receivers[pdo] = receiver
                if self._running and pdo.mapping.fields:
                    receiver.start()
            else:
                self._transmitters[pdo] = TpdoTransmitter(parameters)
                if self._running:
                    self._begin(pdo, now)
        self._index()

    def _index(self) -> None:
        self._by_id, self._carriers = {}, {}
        self._timed_receivers = [
            each for each in self._receivers.items() if each[1].timed
        ]
        self._timed_transmitters = [
            each for each in self._transmitters.items() if each[1].timed
        ]
        self._synchronous_receivers = [
            each for each in self._receivers.items() if each[1].synchronous
        ]
        self._synchronous_transmitters = [
            each for each in self._transmitters.items() if each[1].synchronous
        ]
        for pdo in self._all:
            if pdo.cob_id.valid and pdo.mapping.fields:
                self._by_id.setdefault(pdo.cob_id.can_id, []).append(pdo)
        for pdo, transmitter in self._transmitters.items():
            for number in pdo.mapping.numbers if transmitter.eventful else ():
                self._carriers.setdefault(number, []).append(pdo)

    def _begin(self, pdo: DevicePdo, now: int) -> None:
        if not pdo.mapping.fields:
            return
        transmitter = self._transmitters[pdo]
        transmitter.start(now)
        self._refresh(pdo, now)
        for number in pdo.mapping.numbers:
            is_event = self._is_event.get(number)
            octets = self._dictionary.last(number)
            self._sent[number] = octets
            if transmitter.eventful and (is_event is None or is_event(None, octets)):
                self._due[pdo] = None

    def _note(self, pdo: DevicePdo, number: ObjectNumber) -> None:
        if not self._running or not pdo.cob_id.valid:
            return
        is_event = self._is_event.get(number)
        octets = self._dictionary.last(number)
        if is_event is None or is_event(self._sent.get(number), octets):
            self._due[pdo] = None

    def _refresh(self, pdo: DevicePdo, now: int) -> None:
        self._transmitters[pdo].update(self._pack(pdo), now, event=False)

    def _pack(self, pdo: DevicePdo) -> bytes:
        return pdo.mapping.pack(self._octets)

    def _octets(self, number: ObjectNumber) -> bytes:
        try:
            return self._dictionary.octets(number)
        except SdoAbort:
            return self._dictionary.last(number)

    def _take(self, pdo: DevicePdo, received: Received) -> None:
        if received.emergency:
            self._errors.add(received.emergency, pdo.label)
        if self._errors.active:
            over = () if received.emergency else _LENGTH_ERRORS
            if received.emergency != PDO_TOO_SHORT:
                over = (*over, RPDO_TIMEOUT)
            for code in over:
                self._errors.remove(code, pdo.label)
        if received.data is not None:
            self._unpack(pdo, received.data)

    def _unpack(self, pdo: DevicePdo, data: bytes) -> None:
        for number, octets in pdo.mapping.unpack(data):
            try:
                if octets is None:
                    raise SdoAbort(sdo.VALUE_INVALID)
                self._dictionary.take(number, octets)
            except SdoAbort as abort:
                self.refused += 1
                self._rejected(pdo.number, number, abort)
        self._received(pdo.number)
