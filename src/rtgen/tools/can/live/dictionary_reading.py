"""Reads the object dictionary of a node by SDO, without a description and without a write."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Final

import msgspec

from rtgen.facts.canopen import (
    PDOS,
    RPDO_COMMUNICATION,
    RPDO_MAPPING,
    TPDO_COMMUNICATION,
    TPDO_MAPPING,
)
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import SECOND
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.tools.can.live.bus_session import BusSession, SilentError
from rtgen.tools.can.live.standard_objects import COMMUNICATION

Number = tuple[int, int]

DEVICE_TYPE: Final = (0x1000, 0)
STORE_EDS: Final = (0x1021, 0)
_STORE_FORMAT: Final = (0x1022, 0)
_PLAIN: Final = b"\0"
"""The format of a stored EDS that is not compressed (CiA 301, 7.5.2.20)."""
AREAS: Final = (range(0x1000, 0x2000), range(0x2000, 0x6000), range(0x6000, 0xA000))
"""What is scanned by default: communication, manufacturer and profile areas."""
ABSENT: Final = (sdo.NO_OBJECT, sdo.NO_SUBINDEX)
_LONGEST: Final = 4096
"""Octets that are read of a value; a longer one is a domain."""
_LAST: Final = 254
_GAP: Final = 16
"""Absent sub-indices from 1 on after which an object has none: sub-index 0 was a value."""
_SILENCES: Final = 3
"""Consecutive requests without a response after which the node is gone."""
_PROGRESS: Final = 2.0
"""Seconds between two lines of progress."""


class Reading(msgspec.Struct):
    """What a node has answered, by index and sub-index.

    `refusals` are abort codes of objects that are not absent; `long` has objects of more octets
    than are read, `silent` those without an answer. `stored` is the EDS that the node has stored.
    `stopped` says why not everything has been read, and is empty otherwise.
    """

    values: dict[Number, bytes] = {}
    refusals: dict[Number, int] = {}
    long: set[Number] = set()
    silent: list[Number] = []
    stored: bytes | None = None
    stopped: str = ""

    def exists(self, number: Number) -> bool:
        """Return whether the node has the object for certain."""
        exist = self.refusals.get(number) in (sdo.WRITE_ONLY, sdo.NO_DATA)
        return number in self.values or number in self.long or exist

    @property
    def profile(self) -> int:
        """The number of the device profile, 0 if there is none."""
        return int.from_bytes(self.values.get(DEVICE_TYPE, b"")[:2], "little")

    def mapped(self) -> Iterator[tuple[bool, Number, int]]:
        """Yield the entries of PDOs: whether a TPDO has it, the object, and its bits."""
        for (index, subindex), octets in sorted(self.values.items()):
            sent = TPDO_MAPPING <= index < TPDO_MAPPING + PDOS
            received = RPDO_MAPPING <= index < RPDO_MAPPING + PDOS
            entry = int.from_bytes(octets, "little")
            count = self.values.get((index, 0), b"\0")
            if not (sent or received) or not 1 <= subindex <= count[0] <= 64:
                continue
            yield sent, (entry >> 16, entry >> 8 & 0xFF), entry & 0xFF


class _StopError(Exception):
    """The reading ends early; the text says why."""


class Pace(msgspec.Struct, frozen=True):
    """Bounds in time: `timeout` of a response [s], requests in a second, and `limit` of all [s]."""

    timeout: float
    rate: float
    limit: float


class DictionaryReader:
    """Reads objects of a node into `reading`, each once."""

    def __init__(
        self, session: BusSession, node_id: int, pace: Pace, say: Callable[[str], None]
    ) -> None:
        self.reading = Reading()
        self._session = session
        self._node_id = node_id
        self._pace = pace
        self._say = say
        self._end = time.monotonic() + pace.limit
        self._next = self._progress = time.monotonic()
        self._silences = 0
        self._no_first = False
        """Whether the last object read exists, but not its sub-index."""
        self._indices: set[int] = set()
        self._index = DEVICE_TYPE[0]

    def read(
        self, ranges: Iterable[range], accepted: Callable[[bytes], bool]
    ) -> Reading:
        """Read the communication objects, mapped objects and ranges of indices.

        An EDS that the node has stored, and that is `accepted`, ends it. At Ctrl-C, at the limit of
        time and when the node falls silent, what has been read is returned. Raises SilentError if
        the node answers nothing, ToolError if the bus is lost.
        """
        reading = self.reading
        try:
            self._object(DEVICE_TYPE[0])
            if reading.silent:
                raise SilentError
            if self._stored(accepted):
                return reading
            for index in chain(COMMUNICATION, self._pdos()):
                self._object(index)
            for _, (index, _), _ in list(reading.mapped()):
                self._object(index)
            for index in (index for indices in ranges for index in indices):
                self._object(index)
        except _StopError as stop:
            reading.stopped = str(stop)
        except KeyboardInterrupt:
            reading.stopped = f"interrupted at {self._index:04X}h"
        return reading

    def _stored(self, accepted: Callable[[bytes], bool]) -> bool:
        """Read the stored EDS; return whether it is accepted."""
        try:
            text = self._upload(STORE_EDS, sdo.MAX_SIZE)
            plain = self._upload(_STORE_FORMAT, _LONGEST)
        except SilentError:
            return False
        if text and plain in (_PLAIN, None) and accepted(text):
            self.reading.stored = text
            return True
        return False

    def _pdos(self) -> Iterator[int]:
        """Yield the indices of communication parameters, and of mappings of PDOs that exist."""
        for communication, mapping in (
            (RPDO_COMMUNICATION, RPDO_MAPPING),
            (TPDO_COMMUNICATION, TPDO_MAPPING),
        ):
            for place in range(PDOS):
                yield communication + place
                if self.reading.exists((communication + place, 1)):
                    yield mapping + place

    def _object(self, index: int) -> None:
        """Read an object with its subobjects."""
        if index in self._indices or index < DEVICE_TYPE[0]:
            return
        self._indices.add(index)
        self._index = index
        self._tell(index)
        first = self._value((index, 0))
        if first is not None and len(first) != 1:
            return
        if first is None and not self._perhaps(index):
            return
        count, empty = first[0] if first else 0, 0
        for subindex in range(1, _LAST + 1):
            self._value((index, subindex))
            exists = self.reading.exists((index, subindex))
            empty = 0 if exists else empty + 1
            none = empty == subindex
            if not exists and (subindex > count or (none and empty >= _GAP)):
                break
            if subindex > count and first is not None and self._echoes(index, subindex):
                break
        else:
            self._drop(index, max(count, 1))

    def _perhaps(self, index: int) -> bool:
        """Return whether an object without sub-index 0 has others."""
        if not self._no_first:
            return False
        self._value((index, 1))
        return self.reading.exists((index, 1))

    def _drop(self, index: int, last: int) -> None:
        """Drop what follows the last subobject: the node answers for every sub-index."""
        for subindex in range(last + 1, _LAST + 1):
            for known in (self.reading.values, self.reading.refusals):
                known.pop((index, subindex), None)
            self.reading.long.discard((index, subindex))

    def _echoes(self, index: int, last: int) -> bool:
        """Drop subobjects that are all sub-index 0: the node ignores the sub-index of a value."""
        values = self.reading.values
        numbers = [(index, subindex) for subindex in range(1, last + 1)]
        if any(values.get(number) != values[index, 0] for number in numbers):
            return False
        for number in numbers:
            del values[number]
        return True

    def _value(self, number: Number) -> bytes | None:
        """Read a value; None if there is none to read."""
        reading = self.reading
        if number in reading.values:
            return reading.values[number]
        self._no_first = False
        for _ in range(2):
            try:
                octets = self._upload(number, _LONGEST)
            except SilentError:
                continue
            self._silences = 0
            if octets is not None:
                reading.values[number] = octets
            return octets
        reading.silent.append(number)
        self._silences += 1
        if self._silences >= _SILENCES:
            raise _StopError(f"no answer from {number[0]:04X}h on")
        return None

    def _upload(self, number: Number, longest: int) -> bytes | None:
        """Read an object; None if the node refuses. Raises SilentError, _StopError."""
        self._wait(number)
        timeout = round(self._pace.timeout * SECOND)
        block = longest > _LONGEST
        try:
            return self._session.upload(
                self._node_id, *number, timeout=timeout, block=block, longest=longest
            )
        except SdoAbort as abort:
            if abort.within:
                raise SilentError from abort
            self._no_first = abort.received and abort.code == sdo.NO_SUBINDEX
            if not abort.received and abort.code == sdo.OUT_OF_MEMORY:
                self.reading.long.add(number)
            elif abort.code not in ABSENT:
                self.reading.refusals[number] = abort.code
            return None

    def _wait(self, number: Number) -> None:
        """Wait for the time of the next request. Raises _StopError after the limit."""
        now = time.monotonic()
        if now >= self._end:
            limit = f"{self._pace.limit:g} s"
            raise _StopError(f"the limit of {limit} ended it at {number[0]:04X}h")
        if self._next > now:
            self._session.listen(self._next - now)
        self._next = max(self._next, now) + 1 / self._pace.rate

    def _tell(self, index: int) -> None:
        now = time.monotonic()
        if now >= self._progress + _PROGRESS:
            self._progress = now
            self._say(f"at {index:04X}h: {len(self.reading.values)} values read")
