"""Evidence that two nodes of a bus have the same node-id, as their NMT master can observe it."""

from __future__ import annotations

from typing import Final

from rtgen.runtime.canopen.bus.sdo_channel import SdoChannel

FOREIGN_ANSWERS: Final = "SDO responses arrive without a request"
_MANY_ANSWERS: Final = 3
"""Number of unexpected SDO responses during set-up that indicate a second node (or client)."""
_BEATS: Final = 16
"""Minimum number of heartbeats before their rate is judged."""
_EXCESS: Final = 5, 3
"""More than 5 heartbeats in 3 periods, over a long time, are not those of one node."""


class SecondNodeDetector:
    """Counts heartbeats, boot-up messages and unexpected SDO responses of a node-id.

    `period` is that of the heartbeats, 0 without, `timeout` that of their supervision, in ns.
    """

    def __init__(self, channel: SdoChannel, period: int, timeout: int) -> None:
        self._channel = channel
        self._period = period
        self._timeout = timeout
        self._answers_before = 0
        self._boots = 0
        self._beats = 0
        self._first_beat = 0

    def booted(self, *, again: bool) -> None:
        """Count a boot-up message; `again`: it is not the first since the reset."""
        self._boots = self._boots + 1 if again else 1
        if not again:
            self._answers_before = self._channel.unexpected

    def restart_beats(self) -> None:
        """Start counting heartbeats."""
        self._beats = 0

    def beats_too_often(self, now: int) -> bool:
        """Count a heartbeat; return whether they arrive at twice the rate of one node."""
        if self._beats == 0:
            self._first_beat = now
        self._beats += 1
        period = self._period
        # Delayed heartbeats may arrive in a burst of up to two time-outs.
        if not period or self._beats < max(_BEATS, 6 * self._timeout // period):
            return False
        beats, self._beats = self._beats, 0
        many, periods = _EXCESS
        return many * (now - self._first_beat) < periods * beats * period

    @property
    def answers(self) -> bool:
        """Whether there were several unexpected SDO responses since the boot-up message."""
        return self._channel.unexpected >= self._answers_before + _MANY_ANSWERS

    @property
    def evidence(self) -> str:
        """Evidence for a second node since the reset; empty if there is none."""
        if self._boots > 1:
            return "its boot-up message came twice"
        foreign = self._channel.unexpected > self._answers_before
        return FOREIGN_ANSWERS if foreign else ""
