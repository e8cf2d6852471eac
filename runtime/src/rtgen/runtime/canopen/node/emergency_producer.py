"""Emergency producer of a device, with its active errors (CiA 301, 7.2.7)."""

from __future__ import annotations

from collections import deque
from typing import Final

from rtgen.facts.canopen import INVALID
from rtgen.facts.cob_ids import EMERGENCY_CONSUMERS
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.node.object_dictionary import (
    DeviceDictionary,
    check_cob_id,
)
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.emergency import Emergency, ErrorRegister
from rtgen.runtime.canopen.wire.frames import INHIBIT_UNIT, CobId, Frame
from rtgen.runtime.canopen.wire.sdo import SdoAbort

REGISTER: Final = (0x1001, 0)
HISTORY: Final = 0x1003
COB_ID: Final = 0x1014
INHIBIT_TIME: Final = 0x1015

MAX_WAITING: Final = 16
"""Maximum number of messages waiting for the inhibit time."""
MAX_ERRORS: Final = 64
"""Maximum number of active errors."""

_TRANSIENT: Final = (0x6, 0x8)
"""Classes of errors that reset communication clears."""

_BITS: Final = {
    0x2: ErrorRegister.CURRENT,
    0x3: ErrorRegister.VOLTAGE,
    0x4: ErrorRegister.TEMPERATURE,
    0x8: ErrorRegister.COMMUNICATION,
}


def register_of(code: int) -> ErrorRegister:
    """Return the bits of the error register (1001h) for an error code."""
    if code >> 8 == 0xFF:
        return ErrorRegister.GENERIC | ErrorRegister.MANUFACTURER
    return ErrorRegister.GENERIC | _BITS.get(code >> 12, ErrorRegister(0))


class EmergencyProducer:
    """The active errors of a device; maintains 1001h and 1003h.

    An error is sent once when it occurs, and again with code 0000h and the same additional octets
    when it is cleared. The queue for the inhibit time (1015h) is bounded: the newest messages are
    kept, `lost` counts the others. Without a valid 1014h nothing is sent.
    """

    def __init__(self, dictionary: DeviceDictionary) -> None:
        self._dictionary = dictionary
        self._present: dict[tuple[int, bytes], ErrorRegister] = {}
        self._waiting: deque[Emergency] = deque()
        self._cob_id: CobId | None = None
        self._inhibit = 0
        self._not_before = 0
        self.lost = 0
        dictionary.guard((HISTORY, COB_ID, EMERGENCY_CONSUMERS), self._check)
        dictionary.guard_reading(HISTORY, self._check_history)

    @property
    def register(self) -> ErrorRegister:
        """The value of the error register (1001h)."""
        register = ErrorRegister(0)
        for bits in self._present.values():
            register |= bits
        return register

    @property
    def active(self) -> bool:
        """Whether any error is active."""
        return bool(self._present)

    @property
    def can_id(self) -> int | None:
        """The CAN identifier of emergency messages, None without a valid 1014h."""
        return None if self._cob_id is None else self._cob_id.can_id

    @property
    def deadline(self) -> int | None:
        """When `take` has a message to send."""
        return self._not_before if self._waiting else None

    def configure(self) -> None:
        """Apply 1014h and 1015h."""
        cob_id = CobId(self._dictionary.number((COB_ID, 0), INVALID))
        self._cob_id = cob_id if cob_id.valid else None
        self._inhibit = self._dictionary.number((INHIBIT_TIME, 0)) * INHIBIT_UNIT

    def reset(self, *, whole: bool) -> None:
        """Reset the errors; unless `whole`, only protocol and software errors are cleared."""
        for key in list(self._present):
            if whole or key[0] >> 12 in _TRANSIENT:
                del self._present[key]
        self._waiting.clear()
        self._not_before = 0
        self._update_register()

    def present(self, code: int, additional: bytes = b"") -> bool:
        """Return whether the error is active."""
        return (code, additional) in self._present

    def add(
        self, code: int, additional: bytes = b"", register: ErrorRegister | None = None
    ) -> None:
        """Activate an error; an active error is not sent again.

        Up to 5 additional octets distinguish places or kinds of an error.
        """
        key = code, additional
        if key in self._present:
            return
        bits = register_of(code) if register is None else register
        if len(self._present) < MAX_ERRORS:
            self._present[key] = bits | ErrorRegister.GENERIC
        self._update_register()
        self._emit(code, self.register | bits, additional)

    def event(self, code: int, additional: bytes = b"") -> None:
        """Send an error that is already over."""
        self._emit(code, self.register | register_of(code), additional)

    def remove(self, code: int, additional: bytes | None = None) -> None:
        """Clear an error, or all errors of a code if no additional octets are given."""
        if not self._present:
            return
        removed = [
            key
            for key in self._present
            if key[0] == code and additional in (None, key[1])
        ]
        for key in removed:
            del self._present[key]
            self._update_register()
            self._queue(Emergency(0, self.register, key[1]))

    def take(self, now: int, *, at_once: bool = False) -> list[Frame]:
        """Return the messages that may be sent now; all of them with `at_once`."""
        frames: list[Frame] = []
        while self._waiting and (at_once or now >= self._not_before):
            message = self._waiting.popleft()
            if self._cob_id is not None:
                data = message.frame(1).data
                frames.append(self._cob_id.frame(data))
                self._not_before = now + self._inhibit
        return frames

    def _emit(self, code: int, register: ErrorRegister, additional: bytes) -> None:
        entry = code | int.from_bytes(additional[:2], "little") << 16
        self._update_history(entry)
        self._queue(Emergency(code, register, additional))

    def _queue(self, message: Emergency) -> None:
        if self._cob_id is None:
            return
        if len(self._waiting) == MAX_WAITING:
            self._waiting.popleft()
            self.lost += 1
        self._waiting.append(message)

    def _update_register(self) -> None:
        if REGISTER in self._dictionary:
            self._dictionary.put(REGISTER, bytes((self.register,)))

    def _update_history(self, entry: int) -> None:
        subs = [sub for sub in self._dictionary.subindices(HISTORY) if sub]
        if not subs or (HISTORY, 0) not in self._dictionary:
            return
        count = min(self._dictionary.number((HISTORY, 0)) + 1, len(subs))
        for place in range(len(subs) - 1, 0, -1):
            older = self._dictionary.last((HISTORY, subs[place - 1]))
            self._dictionary.put((HISTORY, subs[place]), older)
        self._dictionary.put((HISTORY, subs[0]), entry.to_bytes(4, "little"))
        self._dictionary.put((HISTORY, 0), bytes((count,)))

    def _check_history(self, number: ObjectNumber) -> None:
        if number[1] > self._dictionary.number((HISTORY, 0)):
            raise SdoAbort(sdo.NO_DATA)

    def _check(self, number: ObjectNumber, value: ObjectValue) -> None:
        if number[0] == HISTORY:
            if value != 0 or number[1]:
                raise SdoAbort(sdo.VALUE_INVALID)
            return
        if number[0] == COB_ID or number[1]:
            check_cob_id(self._dictionary.number(number), value)
