"""The messages that wait for a page: bounded, and never waited for by the run."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from rtgen.ui.protocol.ui import (
    Event,
    EventKind,
    Sample,
    SentLess,
    ServerMessage,
    Statistics,
)

MOST_CHANGES: Final = 4096
"""Changes that wait before the page gets the whole state instead."""
MOST_SAMPLES: Final = 4096
"""Samples that wait before only the newest of each channel is kept."""
MOST_TRAFFIC: Final = 2048
"""Frames and calls that wait before the oldest are dropped."""

_LATEST: Final = (EventKind.EVENT_TIME, EventKind.EVENT_LOAD)
_ALWAYS: Final = (
    EventKind.EVENT_HELLO,
    EventKind.EVENT_RESULT,
    EventKind.EVENT_END,
)
"""What a page gets whatever it shows."""
_TRAFFIC: Final = (EventKind.EVENT_FRAMES, EventKind.EVENT_BOARD_CALL)


@dataclass
class Outbox:
    """What a page has still to get. May be used from any thread; `wake` is called for new messages.

    `full`: the page may change the system. `watched`: the channels whose samples it wants.
    `behind`: it has missed changes and needs the whole state. `past`: the time that it shows [s];
    None for a page that gets what happens as it happens.
    """

    wake: Callable[[], None]
    full: bool = True
    watched: frozenset[int] = frozenset()
    behind: bool = False
    past: float | None = None
    closed: bool = False
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _changes: deque[Event] = field(default_factory=deque)
    _latest: dict[object, Event] = field(default_factory=dict)
    _statistics: dict[str, Statistics] = field(default_factory=dict)
    _traffic: deque[Event] = field(default_factory=deque)
    _samples: list[Sample] = field(default_factory=list)
    _dropped: int = 0
    _thinned: set[int] = field(default_factory=set)

    def put(self, *events: Event) -> None:
        """Messages of any kind but samples and statistics; several come at once."""
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
            if len(self._traffic) > MOST_TRAFFIC:
                self._traffic.popleft()
                self._dropped += 1
        elif kind is EventKind.EVENT_SYSTEM:
            # It contains all changes before it; results of commands stay.
            self._changes = deque(
                e for e in self._changes if e.discriminator in _ALWAYS
            )
            self._changes.append(event)
            self.behind = False
        elif kind is EventKind.EVENT_RESULT or len(self._changes) < MOST_CHANGES:
            self._changes.append(event)
        else:
            self._dropped += 1
            self.behind = True

    def show(self, events: list[Event], past: float | None) -> None:
        """The state at a time, in place of all that waits; `past` is from now on what it says."""
        with self._lock:
            kept = (e for e in self._changes if e.discriminator in _ALWAYS)
            self._changes = deque((*kept, *events))
            self._statistics, self._latest = {}, {}
            self._samples, self._traffic = [], deque()
            self.past, self.behind = past, False
        self.wake()

    def show_more(self, events: list[Event]) -> None:
        """Events that belong to the time that the page shows."""
        with self._lock:
            self._changes.extend(events)
        self.wake()

    @property
    def is_crowded(self) -> bool:
        """Whether so much waits that no more commands should be taken from the page."""
        return len(self._changes) >= MOST_CHANGES

    def sample(self, sample: Sample) -> None:
        """A sample of a channel that the page watches."""
        with self._lock:
            if self.past is not None:
                return
            self._samples.append(sample)
            if len(self._samples) > MOST_SAMPLES:
                newest = {each.channel: each for each in self._samples}
                self._dropped += len(self._samples) - len(newest)
                self._thinned |= newest.keys()
                self._samples = [*newest.values()]
        self.wake()

    def statistics(self, found: list[Statistics]) -> None:
        """The newest statistics of components."""
        with self._lock:
            if self.past is not None:
                return
            self._statistics |= {each.instance: each for each in found}
        self.wake()

    def take(self) -> bytes:
        """Everything that waits as one message; empty if nothing does."""
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
        return ServerMessage(events=events).to_cdr() if events else b""
