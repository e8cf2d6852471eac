"""SYNC and TIME (CiA 301, 7.2.5 and 7.2.6; objects 1005h, 1006h, 1012h and 1019h)."""

from __future__ import annotations

from typing import Final

from rtgen.facts.canopen import (
    EPOCH,
    MILLISECOND,
    SYNC,
    TIME,
    milliseconds_of,
)
from rtgen.runtime.canopen.wire.frames import CobId, Frame

MAX_SYNC_OVERFLOW: Final = 240
PREDEFINED_SYNC: Final = CobId(SYNC)


class SyncProducer:
    """SYNC producer with a period in ns; `overflow` (2 to 240) is the highest counter.

    `cob_id` has the identifier.

    `deadline` is when `poll` has a SYNC to send. SYNCs that are late by more than a period are
    skipped.
    """

    def __init__(
        self, period: int, overflow: int = 0, cob_id: CobId = PREDEFINED_SYNC
    ) -> None:
        if period <= 0:
            raise ValueError(f"period {period}: it is at least 1 ns")
        if overflow and not 2 <= overflow <= MAX_SYNC_OVERFLOW:
            raise ValueError(
                f"overflow {overflow}: it is 0, or 2 to {MAX_SYNC_OVERFLOW}"
            )
        self._period = period
        self._overflow = overflow
        self._cob_id = cob_id
        self._counter = 0
        self.deadline: int | None = None

    def start(self, now: int) -> None:
        """Start immediately, with counter 1 (also when leaving STOPPED: CiA 301, 7.2.5.2)."""
        self._counter = 0
        self.deadline = now

    def stop(self) -> None:
        """Stop."""
        self.deadline = None

    def poll(self, now: int) -> Frame | None:
        """Return the SYNC, if due."""
        if self.deadline is None or now < self.deadline:
            return None
        self.deadline += self._period * (1 + (now - self.deadline) // self._period)
        if not self._overflow:
            return self._cob_id.frame(b"")
        self._counter = self._counter % self._overflow + 1
        return self._cob_id.frame(bytes((self._counter,)))


def sync_counter(frame: Frame) -> int | None:
    """Return the counter of a SYNC, 0 without one; None for any other length (EMCY 8240h)."""
    if len(frame.data) > 1:
        return None
    return frame.data[0] if frame.data else 0


def decode_time(frame: Frame) -> int | None:
    """Return the time in a TIME message, in ns of UTC since 1970; None for any other frame."""
    if frame.can_id != TIME or frame.extended or frame.remote or len(frame.data) != 6:
        return None
    return (EPOCH + milliseconds_of(int.from_bytes(frame.data, "little"))) * MILLISECOND
