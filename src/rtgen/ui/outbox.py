"""The messages that wait for a page: bounded, so that the run never waits."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from rtgen.compiler.kit.translation import ENGLISH
from rtgen.runtime.cdr import CdrError
from rtgen.ui.protocol.ui import (
    Event,
    EventKind,
    Sample,
    SentLess,
    ServerMessage,
    Statistics,
)
from rtgen.ui.texts import in_language, sendable

MAX_CHANGES: Final = 4096
"""Maximum number of waiting changes; then the page gets the whole state instead."""
MAX_SAMPLES: Final = 4096
"""Maximum number of waiting samples; then only the newest of each channel is kept."""
MAX_TRAFFIC: Final = 2048
"""Maximum number of waiting frames and calls; then the oldest are dropped."""

_LATEST: Final = (EventKind.EVENT_TIME, EventKind.EVENT_LOAD, EventKind.EVENT_FLOWS)
_ALWAYS: Final = (
    EventKind.EVENT_HELLO,
    EventKind.EVENT_RESULT,
    EventKind.EVENT_END,
)
"""Kinds of events that a page always gets."""
_TRAFFIC: Final = (EventKind.EVENT_FRAMES, EventKind.EVENT_BOARD_CALL)


@dataclass
class Outbox:
    """The messages for a page. May be used from any thread; `wake` is called for new messages.

    `full`: the page may change the system. `watched`: the channels whose samples it subscribes to.
    `missed_changes`: the page needs the whole state. `past`: the time that the page shows [s]; None
    for the present. `owes`: an answer to a request of the page waits. `language`: that of the
    page's reader, in which it gets texts.
    """

    wake: Callable[[], None]
    full: bool = True
    watched: frozenset[int] = frozenset()
    missed_changes: bool = False
    past: float | None = None
    closed: bool = False
    owes: bool = False
    language: str = ENGLISH
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _changes: deque[Event] = field(default_factory=deque)
    _latest: dict[object, Event] = field(default_factory=dict)
    _statistics: dict[str, Statistics] = field(default_factory=dict)
    _traffic: deque[Event] = field(default_factory=deque)
    _samples: list[Sample] = field(default_factory=list)
    _dropped: int = 0
    _thinned: set[int] = field(default_factory=set)

    def put(self, *events: Event) -> None:
        """Add events of any kind except samples and statistics; several arrive together."""
        with self._lock:
            for event in events:
                self._put(event)
        self.wake()

    def _put(self, event: Event) -> None:
        kind = event.discriminator
        if self.past is not None and kind not in _ALWAYS:
            return
        if kind in _LATEST:
            self._latest[kind] = event
        elif kind in _TRAFFIC:
            self._traffic.append(event)
            if len(self._traffic) > MAX_TRAFFIC:
                self._traffic.popleft()
                self._dropped += 1
        elif kind is EventKind.EVENT_SYSTEM:
            # The state contains all earlier changes; results of commands stay.
            self._changes = deque(
                e for e in self._changes if e.discriminator in _ALWAYS
            )
            self._changes.append(event)
            self.missed_changes = False
        elif kind is EventKind.EVENT_RESULT or len(self._changes) < MAX_CHANGES:
            self._changes.append(event)
            self.owes = self.owes or kind is EventKind.EVENT_RESULT
        else:
            self._dropped += 1
            self.missed_changes = True

    def show(self, events: list[Event], past: float | None) -> None:
        """Show the state at a time instead of all waiting events; sets `past`."""
        with self._lock:
            sent = (e for e in self._changes if e.discriminator in _ALWAYS)
            self._changes = deque((*sent, *events))
            self._statistics, self._latest = {}, {}
            self._samples, self._traffic = [], deque()
            self.past, self.missed_changes = past, False
            self.owes = True
        self.wake()

    def show_more(self, events: list[Event]) -> None:
        """Add events of the time that the page shows."""
        with self._lock:
            self._changes.extend(events)
            self.owes = True
        self.wake()

    @property
    def is_crowded(self) -> bool:
        """Whether too much waits to accept further commands from the page."""
        return len(self._changes) >= MAX_CHANGES

    def sample(self, sample: Sample) -> None:
        """Add a sample of a channel that the page watches."""
        with self._lock:
            if self.past is not None:
                return
            self._samples.append(sample)
            if len(self._samples) > MAX_SAMPLES:
                newest = {each.channel: each for each in self._samples}
                self._dropped += len(self._samples) - len(newest)
                self._thinned |= newest.keys()
                self._samples = [*newest.values()]
        self.wake()

    def show_samples(self, samples: list[Event], channels: frozenset[int]) -> None:
        """Show samples of channels instead of those that wait."""
        with self._lock:
            if self.past is not None:
                return
            self._samples = [s for s in self._samples if s.channel not in channels]
            self._changes.extend(samples)
        self.wake()

    def statistics(self, latest: list[Statistics]) -> None:
        """Set the newest statistics of components."""
        with self._lock:
            if self.past is not None:
                return
            self._statistics |= {each.instance: each for each in latest}
        self.wake()

    def take(self) -> bytes:
        """Return all waiting events as one message, and remove them; empty if there are none."""
        with self._lock:
            events = [*self._changes]
            if self._statistics:
                events.append(Event.of_statistics([*self._statistics.values()]))
            if self._samples:
                events.append(Event.of_samples(self._samples))
            events += self._traffic
            events += self._latest.values()
            if self._dropped:
                less = SentLess(dropped=self._dropped, channels=sorted(self._thinned))
                events.append(Event.of_less(less))
            self._changes, self._traffic = deque(), deque()
            self._statistics, self._latest, self._samples = {}, {}, []
            self._dropped, self._thinned = 0, set()
            self.owes = False
        if not events:
            return b""
        if self.language != ENGLISH:
            events = [in_language(event, self.language) for event in events]
        message = ServerMessage(events=events)
        try:
            return message.to_cdr()
        except CdrError:
            octets: bytes = sendable(message).to_cdr()
            return octets
