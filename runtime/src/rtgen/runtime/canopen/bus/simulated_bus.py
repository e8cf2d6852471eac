"""A CAN bus in simulated time, driven by the scheduler of its system."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import Final, TypeAlias

from rtgen.runtime.canopen.bus.arbitration import Arbiter, transmission_time
from rtgen.runtime.canopen.bus.link import Station
from rtgen.runtime.canopen.bus.shared_link import AttachedStation, SharedLink
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.timing.instants import Instants, SimulatedTime

Disturbance: TypeAlias = Callable[[Frame, int], Iterable[tuple[int, Frame]]]
"""Function from a transmitted frame and its time to the frames to deliver, each with a delay in ns.

An empty result loses the frame, two frames duplicate it.
"""

_QUEUE: Final = 16384
"""Capacity of a station's queue in frames."""
_BURST: Final = 65536
"""Maximum number of frames at the same time on a bus without bit rate; then time advances."""


class SimulatedCanBus(SharedLink):
    """The link of all stations of a system on one channel.

    `bit_rate` is in bit/s; with 0 frames take no time. Queued frames are sent in order of
    arbitration, after the ticks at that time; frames of one station keep their order. A frame is
    delivered at the end of its transmission. A run is deterministic.
    """

    def __init__(self, clock: SimulatedTime, channel: str) -> None:
        super().__init__(f"the simulated bus {channel}")
        if clock.instants is None:
            raise LinkError(f"{self.bus}: no system runs on its clock")
        self.bit_rate = 0
        self.disturbance: Disturbance | None = None
        """Faults of the bus, for tests."""
        self._clock = clock
        self._instants: Instants = clock.instants
        self._up = True
        self._arbiter: Arbiter[AttachedStation | None] = Arbiter()
        self._under_way: tuple[AttachedStation | None, Frame] | None = None
        self._turn_is_due = False
        self._wake: int | None = None
        self._lock = nullcontext()
        self._instant = 0
        self._burst = 0

    @property
    def lock(self) -> AbstractContextManager[object]:
        """See `Link`; there is only one thread."""
        return self._lock

    @property
    def up(self) -> bool:
        """See `Link`."""
        return self._up

    def now(self) -> int:
        """See `Link`."""
        return self._clock.time

    def wait(self, until: Callable[[], bool], timeout: int) -> bool:
        """See `Link`: no time passes."""
        for _ in range(_BURST):
            if until():
                return True
            if self._under_way is None and not self._arbiter:
                self._poll(self.now())
            if self._under_way is not None:
                self._arrive()
            elif self._arbiter:
                self._carry(*self._arbiter.take())
            else:
                break
        return until()

    # For tests

    def cut(self, *stations: Station) -> None:
        """Bus-off: the given stations, by default all, neither send nor receive."""
        self._switch(stations, False)

    def mend(self, *stations: Station) -> None:
        """End the effect of `cut`."""
        self._switch(stations, True)

    def _switch(self, stations: tuple[Station, ...], up: bool) -> None:
        if not stations:
            self._up = up
        ends = [self._attached.find(station) for station in stations]
        known = [attached for attached in ends if attached is not None]
        for attached in known if stations else self._attached:
            if not up:
                self._drop(attached)
            self._turn(attached, up, self.now())
        if not up and not stations:
            self.lost += self._arbiter.clear()
            self._under_way = None
        self._timers_changed()

    # Bus

    def _put(self, frames: Iterable[Frame], attached: AttachedStation | None) -> None:
        arbiter = self._arbiter
        off = not self._up or (attached is not None and not attached.up)
        for frame in frames:
            if off or arbiter.waiting(attached) >= _QUEUE:
                self.lost += 1
            else:
                arbiter.put(attached, frame)
        self._begin()

    def _begin(self) -> None:
        """Schedule arbitration if the bus is free, after all stations have been called."""
        if self._under_way is None and not self._turn_is_due and self._arbiter:
            self._turn_is_due = True
            self._instants.after_ticks(self._arbitrate)

    def _arbitrate(self) -> None:
        self._turn_is_due = False
        while self._arbiter and self._under_way is None:
            attached, frame = self._arbiter.take()
            if self.bit_rate:
                self._start(attached, frame, transmission_time(frame, self.bit_rate))
            elif self._too_many():
                self._start(attached, frame, MILLISECOND)
            else:
                self._carry(attached, frame)

    def _start(self, attached: AttachedStation | None, frame: Frame, time: int) -> None:
        under_way = self._under_way = attached, frame

        def end() -> None:
            # Meanwhile the frame may have been dropped, or delivered by `wait`.
            if self._under_way is under_way:
                self._arrive()

        self._instants.at(self.now() + time, end)

    def _arrive(self) -> None:
        if self._under_way is not None:
            attached, frame = self._under_way
            self._under_way = None
            self._carry(attached, frame)
            self._begin()

    def _carry(self, attached: AttachedStation | None, frame: Frame) -> None:
        now = self.now()
        if self.disturbance is None:
            self._give(frame, attached, now)
        else:
            for delay, carried in self.disturbance(frame, now):
                self._later(delay, attached, carried)
        self._timers_changed()

    def _later(
        self, delay: int, attached: AttachedStation | None, frame: Frame
    ) -> None:
        def arrive() -> None:
            if self._up:
                self._give(frame, attached, self.now())
                self._timers_changed()

        if delay:
            self._instants.at(self.now() + delay, arrive)
        else:
            arrive()

    def _too_many(self) -> bool:
        now = self.now()
        if now != self._instant:
            self._instant, self._burst = now, 0
        self._burst += 1
        return self._burst > _BURST

    def _timers_changed(self) -> None:
        deadline = self._attached.deadline
        if deadline is not None and (self._wake is None or deadline < self._wake):
            self._wake = deadline
            self._instants.at(deadline, lambda: self._ring(deadline))

    def _ring(self, instant: int) -> None:
        if instant != self._wake:
            return
        self._wake = None
        self._poll(self.now())
        self._timers_changed()

    def _drop(self, attached: AttachedStation) -> None:
        self.lost += self._arbiter.drop(attached)
        if self._under_way is not None and self._under_way[0] is attached:
            self.lost += 1
            self._under_way = None
            self._begin()

    def _close(self) -> None:
        self._arbiter.clear()
        self._under_way = None
