"""SYNC and TIME of a device: consumers and the SYNC producer (CiA 301, 7.2.5, 7.2.6)."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.emergency_producer import EmergencyProducer
from rtgen.runtime.canopen.node.object_dictionary import DeviceDictionary
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SYNC, TIME, CobId, Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.canopen.wire.sync import (
    MAX_SYNC_OVERFLOW,
    SyncProducer,
    decode_time,
    sync_counter,
)

COB_ID_SYNC: Final = (0x1005, 0)
SYNC_PERIOD: Final = (0x1006, 0)
SYNC_OVERFLOW: Final = (0x1019, 0)
COB_ID_TIME: Final = (0x1012, 0)
SYNC_LENGTH: Final = 0x8240

_MICROSECOND: Final = 1000


class DeviceSync:
    """SYNC as configured by 1005h, 1006h and 1019h; a wrong length is EMCY 8240h.

    With an identifier that cannot be configured there is no SYNC.
    """

    indices: Final = frozenset((COB_ID_SYNC[0], SYNC_PERIOD[0], SYNC_OVERFLOW[0]))

    def __init__(self, dictionary: DeviceDictionary, errors: EmergencyProducer) -> None:
        self._dictionary = dictionary
        self._errors = errors
        self._producer: SyncProducer | None = None
        self._size: int | None = None
        """The expected length of a SYNC in octets; None: 0 or 1."""
        self._cob_id = CobId(SYNC)
        dictionary.guard((COB_ID_SYNC[0],), self._check_cob_id)
        dictionary.guard((SYNC_OVERFLOW[0],), self._check_overflow)

    @property
    def identifiers(self) -> frozenset[int]:
        """The CAN identifier of SYNC, if the device can have it."""
        cob_id = self._cob_id
        return frozenset((cob_id.can_id,) if cob_id.configurable else ())

    @property
    def deadline(self) -> int | None:
        """Time of the next SYNC."""
        return None if self._producer is None else self._producer.deadline

    def configure(self) -> None:
        """Apply the objects; `start` starts the producer."""
        number = self._dictionary.number
        cob_id = self._cob_id = CobId(number(COB_ID_SYNC, SYNC))
        if SYNC_OVERFLOW in self._dictionary:
            self._size = 1 if number(SYNC_OVERFLOW) else 0
        period = number(SYNC_PERIOD) * _MICROSECOND
        self._producer = None
        if cob_id.bit30 and cob_id.configurable and period:
            overflow = number(SYNC_OVERFLOW)
            self._producer = SyncProducer(period, overflow, cob_id)

    def start(self, now: int) -> None:
        """Start the producer, once the node may send SYNC."""
        if self._producer is not None:
            self._producer.start(now)

    def poll(self, now: int) -> Frame | None:
        """Return the SYNC that is due."""
        return None if self._producer is None else self._producer.poll(now)

    def counter(self, frame: Frame) -> int | None:
        """Return the counter of a SYNC, 0 without one; None for any other frame.

        A device without 1019h accepts both lengths.
        """
        if not self._cob_id.carries(frame) or frame.remote:
            return None
        counter = sync_counter(frame)
        if self._size is not None and len(frame.data) != self._size:
            counter = None
        if counter is None:
            self._errors.add(SYNC_LENGTH)
        else:
            self._errors.remove(SYNC_LENGTH)
        return counter

    def _check_cob_id(self, number: ObjectNumber, value: ObjectValue) -> None:
        old, new = self._cob_id, CobId(int(value))
        moves = (old.can_id, old.extended) != (new.can_id, new.extended)
        if old.bit30 and new.bit30 and moves:
            raise SdoAbort(sdo.VALUE_INVALID)
        if not new.configurable:
            raise SdoAbort(sdo.VALUE_INVALID)

    def _check_overflow(self, number: ObjectNumber, value: ObjectValue) -> None:
        changes = value != self._dictionary.number(SYNC_OVERFLOW)
        if changes and self._dictionary.number(SYNC_PERIOD):
            raise SdoAbort(sdo.DEVICE_STATE)
        if value == 1 or int(value) > MAX_SYNC_OVERFLOW:
            raise SdoAbort(sdo.VALUE_INVALID)


class DeviceTime:
    """The TIME consumer, if 1012h configures one."""

    def __init__(self, dictionary: DeviceDictionary) -> None:
        self._dictionary = dictionary
        dictionary.guard((COB_ID_TIME[0],), self._check)

    @property
    def identifiers(self) -> frozenset[int]:
        """The CAN identifier of TIME, if the device consumes it."""
        cob_id = self._cob_id
        is_consumed = cob_id.bit31 and cob_id.configurable
        return frozenset((cob_id.can_id,) if is_consumed else ())

    def moment(self, frame: Frame) -> int | None:
        """Return the time in a TIME message, in ns of UTC since 1970; None for any other frame."""
        cob_id = self._cob_id
        if not cob_id.bit31 or not cob_id.carries(frame):
            return None
        return decode_time(Frame(TIME, frame.data, frame.remote))

    @property
    def _cob_id(self) -> CobId:
        return CobId(self._dictionary.number(COB_ID_TIME))

    def _check(self, number: ObjectNumber, value: ObjectValue) -> None:
        old, new = self._cob_id, CobId(int(value))
        exists = (old.bit31 or old.bit30) and (new.bit31 or new.bit30)
        moves = (old.can_id, old.extended) != (new.can_id, new.extended)
        if exists and moves:
            raise SdoAbort(sdo.VALUE_INVALID)
        if not new.configurable:
            raise SdoAbort(sdo.VALUE_INVALID)
