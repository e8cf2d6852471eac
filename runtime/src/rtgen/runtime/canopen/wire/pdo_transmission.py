"""Transmission of PDOs: when they are sent and applied (CiA 301, 7.2.2, 7.5.2.35 to 7.5.2.37).

The content of a PDO is opaque here: data are octets.
"""

from __future__ import annotations

from typing import Final

import msgspec

from rtgen.facts.canopen import MAX_SYNC_CYCLIC
from rtgen.runtime.canopen.wire.emergency import (
    PDO_TOO_LONG,
    PDO_TOO_SHORT,
    RPDO_TIMEOUT,
)
from rtgen.runtime.canopen.wire.frames import (
    INHIBIT_UNIT,
    MAX_DATA,
    MILLISECOND,
    CobId,
    Frame,
)

SYNC_ACYCLIC: Final = 0
RTR_SYNC: Final = 252
RTR: Final = 253
EVENT_MANUFACTURER: Final = 254
EVENT_PROFILE: Final = 255

_EVENT: Final = (EVENT_MANUFACTURER, EVENT_PROFILE)


def is_synchronous(transmission_type: int) -> bool:
    """Return whether the transmission type is synchronous: 0 to 240."""
    return transmission_type <= MAX_SYNC_CYCLIC


class PdoParameters(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """Communication parameters of a PDO, in the units of the object dictionary.

    `cob_id` includes the flag bits. `inhibit_time` is in 100 us, `event_timer` in ms;
    `sync_start` is the SYNC counter to start with, 0 for none. Raises ValueError for a reserved
    transmission type, and for a SYNC start value over 240.
    """

    cob_id: int
    transmission_type: int
    inhibit_time: int = 0
    event_timer: int = 0
    sync_start: int = 0

    def __post_init__(self) -> None:
        kind = self.transmission_type
        if not 0 <= kind <= 255 or MAX_SYNC_CYCLIC < kind < RTR_SYNC:
            raise ValueError(f"transmission type {kind} is reserved")
        if not 0 <= self.sync_start <= MAX_SYNC_CYCLIC:
            raise ValueError(f"SYNC start {self.sync_start}: it is up to 240")


class TpdoTransmitter:
    """Decides when a TPDO is sent; `update` sets its data.

    Nothing is sent before `start` (OPERATIONAL), after `stop`, or without data. `deadline` is when
    `poll` must be called. `overwritten` counts events whose data were replaced before they were
    sent.
    """

    def __init__(self, parameters: PdoParameters) -> None:
        self._cob_id = CobId(parameters.cob_id)
        self._type = parameters.transmission_type
        self._inhibit = parameters.inhibit_time * INHIBIT_UNIT
        timed = self._type in _EVENT and parameters.event_timer
        self._event_timer = parameters.event_timer * MILLISECOND if timed else 0
        self._sync_start = parameters.sync_start
        self._data: bytes | None = None
        self._sampled: bytes | None = None
        self._pending = False
        self._running = False
        self._syncs = 0
        self._synced = False
        self._not_before: int | None = None
        self._expires: int | None = None
        self.overwritten = 0

    @property
    def timed(self) -> bool:
        """Whether it can have a deadline; inhibit time and event timer only apply to events."""
        return self._type in _EVENT

    @property
    def eventful(self) -> bool:
        """Whether a change of its data triggers it, immediately or at the next SYNC."""
        return self._type == SYNC_ACYCLIC or self._type in _EVENT

    @property
    def synchronous(self) -> bool:
        """Whether SYNC affects it."""
        return self._type <= RTR_SYNC

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll`; None for never."""
        if not self._running or self._type not in _EVENT or self._data is None:
            return None
        if self._pending:
            return self._not_before
        if self._expires is None or self._not_before is None:
            return self._expires
        return max(self._expires, self._not_before)

    def start(self, now: int) -> None:
        """Enter OPERATIONAL; SYNCs and the event timer are counted from here."""
        if not self._cob_id.valid:
            return
        self._running, self._pending = True, False
        self._syncs, self._synced = 0, not self._sync_start
        self._sampled = None
        self._expires = now + self._event_timer if self._event_timer else None

    def stop(self) -> None:
        """Leave OPERATIONAL; a pending event is dropped."""
        self._running = False

    def update(self, data: bytes, now: int, *, event: bool = True) -> Frame | None:
        """Set new data; return the frame to send immediately.

        `event`: the data are sent (types 0, 254 and 255), not only stored. Raises ValueError for
        more than 8 octets.
        """
        if len(data) > MAX_DATA:
            raise ValueError(f"{len(data)} octets; a PDO has up to {MAX_DATA}")
        self._data = data
        if not (event and self._running and self.eventful):
            return None
        if self._pending:
            self.overwritten += 1
        self._pending = True
        return self.poll(now)

    def sync(self, counter: int, now: int) -> Frame | None:
        """Process a SYNC with its counter (0 without one); return the frame to send."""
        due, data = self._count(counter), self._data
        if not self._running or data is None:
            return None
        if self._type == SYNC_ACYCLIC and self._pending:
            return self._send(data, now)
        if self._type == RTR_SYNC:
            self._sampled = data
        return self._send(data, now) if due else None

    def remote(self, now: int) -> Frame | None:
        """Return the response to a remote frame, if allowed by the COB-ID and inhibit time."""
        if not self._running or self._cob_id.bit30 or self._data is None:
            return None
        if self._type == RTR_SYNC:
            sampled = self._sampled
            return None if sampled is None else self._cob_id.frame(sampled)
        if self._type in _EVENT:
            self._pending = True
            return self.poll(now)
        return self._send(self._data, now)

    def poll(self, now: int) -> Frame | None:
        """Process inhibit time and event timer; return the frame to send."""
        if not self._running or self._type not in _EVENT or self._data is None:
            return None
        expired = self._expires is not None and now >= self._expires
        inhibited = self._not_before is not None and now < self._not_before
        if inhibited or not (self._pending or expired):
            return None
        return self._send(self._data, now)

    def _count(self, counter: int) -> bool:
        """Count a SYNC; return whether the PDO is due in its cycle."""
        if not self._running or not 1 <= self._type <= MAX_SYNC_CYCLIC:
            return False
        if not self._synced:
            if counter and counter != self._sync_start:
                return False
            self._synced = True
            self._syncs = 0 if not counter else self._type - 1
        self._syncs += 1
        if self._syncs < self._type:
            return False
        self._syncs = 0
        return True

    def _send(self, data: bytes, now: int) -> Frame:
        self._pending = False
        if self._type in _EVENT:
            self._not_before = now + self._inhibit if self._inhibit else None
            self._expires = now + self._event_timer if self._event_timer else None
        return self._cob_id.frame(data)


class Received(msgspec.Struct, frozen=True, gc=False):
    """Result of a received RPDO: `data` to apply now, and an EMCY code or 0."""

    data: bytes | None = None
    emergency: int = 0


_NOTHING: Final = Received()


class RpdoReceiver:
    """Decides when the data of an RPDO of `size` octets are applied.

    A short PDO is dropped (EMCY 8210h), a long one is truncated (8220h); both are counted. Types
    0 to 240 are applied at the next SYNC, and only the newest. With an event timer, supervision
    starts with the first PDO; at `deadline` the PDO is overdue (8250h).
    """

    def __init__(self, parameters: PdoParameters, size: int) -> None:
        if not 0 <= size <= MAX_DATA:
            raise ValueError(f"{size} octets; a PDO has up to {MAX_DATA}")
        self._cob_id = CobId(parameters.cob_id)
        self.synchronous = is_synchronous(parameters.transmission_type)
        """Whether SYNC affects it."""
        self._timeout = parameters.event_timer * MILLISECOND
        self._size = size
        self._running = False
        self._waiting: bytes | None = None
        self.deadline: int | None = None
        self.too_short = 0
        self.too_long = 0
        self.overwritten = 0
        """Number of PDOs replaced by newer ones before the SYNC."""

    @property
    def timed(self) -> bool:
        """Whether it can have a deadline."""
        return bool(self._timeout)

    def start(self) -> None:
        """Enter OPERATIONAL."""
        self._running = self._cob_id.valid

    def stop(self) -> None:
        """Leave OPERATIONAL; data that wait for a SYNC are dropped."""
        self._running, self._waiting, self.deadline = False, None, None

    def receive(self, frame: Frame, now: int) -> Received:
        """Process a frame."""
        if not self._running or frame.remote or not self._cob_id.carries(frame):
            return _NOTHING
        if len(frame.data) < self._size:
            self.too_short += 1
            return Received(emergency=PDO_TOO_SHORT)
        code = 0
        if len(frame.data) > self._size:
            self.too_long += 1
            code = PDO_TOO_LONG
        if self._timeout:
            self.deadline = now + self._timeout
        data = frame.data[: self._size]
        if not self.synchronous:
            return Received(data, code)
        if self._waiting is not None:
            self.overwritten += 1
        self._waiting = data
        return Received(emergency=code)

    def sync(self) -> bytes | None:
        """Process a SYNC; return the data waiting for it."""
        data, self._waiting = self._waiting, None
        return data

    def poll(self, now: int) -> int:
        """Return 8250h, once, when the PDO is overdue; else 0."""
        if self.deadline is None or now < self.deadline:
            return 0
        self.deadline = None
        return RPDO_TIMEOUT
