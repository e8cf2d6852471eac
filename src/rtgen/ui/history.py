"""The events of a run so far, in bounded memory, to show pages its state at any time."""

from __future__ import annotations

import copy
import math
import threading
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from heapq import nlargest
from itertools import islice
from operator import attrgetter, itemgetter
from typing import Any, Final

from msgspec.structs import replace

from rtgen.ui.errors import BAD_VALUE, CommandError
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import Event, EventKind

MAX_OCTETS: Final = 64 << 20
"""Approximate size of the kept samples, frames and calls; beyond, the oldest quarter of the time
is dropped.
"""
MAX_CHANGES: Final = 20_000
"""Maximum number of single changes; of earlier ones only the newest of each subject is kept."""
MAX_LINES: Final = 500
"""Maximum number of lines of the timeline for a page."""

_OVERHEAD: Final = 200
"""Approximate size of a message without its data [octets]."""
_FRAME: Final = 1500
_NEWEST: Final = {"sample": ui.MAX_SAMPLES // 2, "calls": 1000, "loads": 600}
"""Number of newest items for a page, which keeps no more; 1 for other kinds."""
_OLDER: Final = {"sample": ui.MAX_SAMPLES // 2}
"""Maximum number of older items for a page, evenly over the run."""
_FRAMES: Final = 1000
"""Maximum number of the newest frames of all buses for a page."""
_OLDER_FRAMES: Final = 2000
"""Maximum number of older frames, shared equally by the identifiers."""
_LINES: Final = frozenset(
    (EventKind.EVENT_STATE, EventKind.EVENT_BESIDE, EventKind.EVENT_NOTICE)
)
_NOT_KEPT: Final = frozenset(
    (
        EventKind.EVENT_HELLO,
        EventKind.EVENT_SYSTEM,
        EventKind.EVENT_TYPES,
        EventKind.EVENT_TIME,
        EventKind.EVENT_EDITS,
        EventKind.EVENT_SENT_LESS,
        EventKind.EVENT_RESULT,
        EventKind.EVENT_END,
    )
)

_Key = tuple[object, ...]


@dataclass(slots=True)
class _Row:
    """Messages of one kind in the order of their times."""

    times: list[float] = field(default_factory=list)
    items: list[Any] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)

    def put(self, time: float, item: Any, size: int) -> None:
        self.times.append(time)
        self.items.append(item)
        self.sizes.append(size)

    def until(self, time: float, newest: int, older: int = 0) -> list[Any]:
        """Return the newest items until a time, and some older ones, evenly distributed."""
        end = bisect_right(self.times, time)
        begin = max(0, end - newest)
        if begin <= older:
            return self.items[:end] if older else self.items[begin:end]
        before = (self.items[i * begin // older] for i in range(older))
        return [*before, *self.items[begin:end]]

    def count_from(self, time: float, until: float) -> int:
        """Return the number of items from a time until another one."""
        return bisect_right(self.times, until) - bisect_left(self.times, time)

    def between(self, start: float, end: float) -> list[Any]:
        """Return the items from a time on, before another one."""
        return self.items[bisect_left(self.times, start) : bisect_left(self.times, end)]

    def drop(self, time: float) -> int:
        """Drop the items up to a time; return their size in octets."""
        end = bisect_right(self.times, time)
        dropped = sum(islice(self.sizes, end))
        del self.times[:end], self.items[:end], self.sizes[:end]
        return dropped


class History:
    """The run of one system from the state of `begin` on. May be used from any thread.

    `first` and `last` are the limits of the time that can be shown [s].
    """

    def __init__(self, max_octets: int = MAX_OCTETS) -> None:
        self.first = self.last = 0.0
        self._start = ui.SystemState()
        self._most = max_octets
        self._octets = 0
        self._lock = threading.Lock()
        self._rows: dict[_Key, _Row] = {}
        self._changes: deque[tuple[float, Event]] = deque()
        self._before: dict[_Key, Event] = {}
        self._lines_before: deque[Event] = deque(maxlen=MAX_LINES)
        self._channels: dict[int, ui.Channel] = {}

    def begin(self, whole: ui.SystemState) -> None:
        """Set the state of the system at the start; sorts the changes of two runs by time."""
        self._start = copy.deepcopy(whole)
        self._channels |= {each.id: each for each in whole.channels}
        self._changes = deque(sorted(self._changes, key=itemgetter(0)))

    def nearest(self, time: float) -> float:
        """Return the nearest time that can be shown. Raises CommandError if it is not a number."""
        if not math.isfinite(time):
            raise CommandError(BAD_VALUE, f"{time} is not a time")
        return min(max(time, self.first), self.last)

    def reach(self, time: float) -> None:
        """Extend the history to a time without an event."""
        self.last = max(self.last, time)

    def sample(self, sample: ui.Sample) -> None:
        """Add a sample of a channel."""
        size = _OVERHEAD + len(sample.data)
        self._put(("sample", sample.channel), sample.time, sample, size)

    def statistics(self, time: float, latest: Iterable[ui.Statistics]) -> None:
        """Add statistics of components."""
        for each in latest:
            self._put(("statistics", each.instance), time, each, _OVERHEAD)

    def add(self, time: float, event: Event) -> None:
        """Add an event that was sent to pages."""
        kind = event.discriminator
        match kind:
            case EventKind.EVENT_FRAMES:
                for frame in event.traffic:
                    key = "frames", frame.bus, frame.can_id, frame.extended
                    self._put(key, time, frame, _FRAME)
            case EventKind.EVENT_BOARD_CALL:
                size = _OVERHEAD + len(event.call.request) + len(event.call.reply)
                self._put(("calls",), time, event, size)
            case EventKind.EVENT_LOAD:
                self._put(("loads", event.carried.bus), time, event, _OVERHEAD)
            case EventKind.EVENT_CHANNEL:
                self._channels[event.opened.id] = event.opened
            case _ if kind not in _NOT_KEPT:
                self._change(time, event)

    def _change(self, time: float, event: Event) -> None:
        if event.discriminator is EventKind.EVENT_BUS:
            event = copy.deepcopy(event)  # The nodes in it change later.
        with self._lock:
            self.reach(time)
            self._changes.append((time, event))
            if len(self._changes) > MAX_CHANGES:
                self.first = max(self.first, self._changes[0][0])
                _, oldest = self._changes.popleft()
                _overwrite(self._before, oldest)
                if oldest.discriminator in _LINES:
                    self._lines_before.append(oldest)

    def _put(self, key: _Key, time: float, item: Any, size: int) -> None:
        with self._lock:
            if time < self.first:
                return
            self.reach(time)
            self._rows.setdefault(key, _Row()).put(time, item, size)
            self._octets += size
            if self._octets > self._most:
                self.first += (self.last - self.first) / 4
                self._octets -= sum(r.drop(self.first) for r in self._rows.values())

    def at(
        self, time: float, types: list[ui.TypeNode], watched: Collection[int]
    ) -> list[Event]:
        """Return the events to show a time: the state, then what led to it.

        Samples are those of the channels that the page watches; `types` are those known so far.
        """
        clock = replace(
            self._start.time,
            playing=False,
            now=time,
            past=True,
            first=self.first,
            last=self.last,
        )
        with self._lock:
            whole = replace(
                self._start,
                types=[*types],
                channels=[*self._channels.values()],
                time=clock,
            )
            happened = [event for t, event in self._changes if t <= time]
            statistics = self._until("statistics", time)
            frames = self._frames(time)
            traffic = [*self._until("calls", time), *self._until("loads", time)]
            newest = dict(self._before)
            lines_before = [*self._lines_before]
        before = [*newest.values()]
        for event in happened:
            _overwrite(newest, event)
        lines = [*lines_before, *happened]
        lines = [each for each in lines if each.discriminator in _LINES][-MAX_LINES:]
        included = {id(event) for event in (*newest.values(), *lines)}
        passed = {id(event): event for event in (*lines_before, *before, *happened)}
        return [
            Event.of_whole(whole),
            *(event for number, event in passed.items() if number in included),
            Event.of_statistics(statistics),
            Event.of_traffic(frames),
            *traffic,
            *self.samples(time, watched),
        ]

    def samples(self, time: float, channels: Iterable[int]) -> list[Event]:
        """Return samples of channels up to a time."""
        with self._lock:
            events = [
                sample
                for channel in channels
                if ("sample", channel) in self._rows
                for sample in self._rows["sample", channel].until(
                    time, _NEWEST["sample"], _OLDER["sample"]
                )
            ]
        return [Event.of_samples(events)] if events else []

    def samples_between(
        self, start: float, end: float, channels: Iterable[int]
    ) -> list[ui.Sample]:
        """Return all samples of channels from a time on, before another one."""
        with self._lock:
            return [
                sample
                for channel in channels
                if ("sample", channel) in self._rows
                for sample in self._rows["sample", channel].between(start, end)
            ]

    def changes_between(self, start: float, end: float) -> list[Event]:
        """Return all changes from a time on, before another one."""
        with self._lock:
            return [event for time, event in self._changes if start <= time < end]

    def _until(self, kind: str, time: float) -> list[Any]:
        most = _NEWEST.get(kind, 1)
        return [item for row in self._of(kind) for item in row.until(time, most)]

    def _frames(self, time: float) -> list[ui.Frame]:
        """Return the newest frames, after some older ones of each identifier, for their signals."""
        rows = self._of("frames")
        times = (each.until(time, _FRAMES) for each in rows)
        newest = nlargest(_FRAMES, (each.time for row in times for each in row))
        first = newest[-1] if newest else 0.0
        older = _OLDER_FRAMES // max(len(rows), 1)
        frames = [
            frame
            for row in rows
            for frame in row.until(time, row.count_from(first, time), older)
        ]
        return sorted(frames, key=attrgetter("time"))

    def _of(self, kind: str) -> list[_Row]:
        return [row for key, row in self._rows.items() if key[0] == kind]


def _overwrite(newest: dict[_Key, Event], event: Event) -> None:
    """Replace the event that a newer one supersedes, keeping the order of events."""
    key = _key(event)
    if key is not None:
        newest.pop(key, None)
        newest[key] = event


def _key(event: Event) -> _Key | None:
    """Return the subject of an event, which a later event of it supersedes; None for a notice."""
    kind = event.discriminator
    match kind:
        case EventKind.EVENT_NOTICE:
            return None
        case EventKind.EVENT_NAMING:
            return (kind,)
        case EventKind.EVENT_COMPONENT:
            return "component", event.described.instance
        case EventKind.EVENT_REMOVED:
            return "component", event.removed
        case EventKind.EVENT_CONNECTED:
            return "connection", event.connected.name
        case EventKind.EVENT_CUT:
            return "connection", event.cut
        case EventKind.EVENT_PARAMETER:
            setting = event.setting
            return kind, setting.instance, setting.set, setting.parameter
        case EventKind.EVENT_BUS:
            return kind, event.described_bus.name
    about: Any = event.value
    return kind, about.instance
