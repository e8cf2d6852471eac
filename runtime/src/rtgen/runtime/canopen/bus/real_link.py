"""A link in real time: a python-can bus with threads for reception and timers, and transmission."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from queue import SimpleQueue
from typing import Final

from rtgen.runtime.canopen.bus.bell import Bell
from rtgen.runtime.canopen.bus.link import Station
from rtgen.runtime.canopen.bus.python_can import BusAddress, OpenBus, open_bus
from rtgen.runtime.canopen.bus.shared_link import AttachedStation, SharedLink
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import SECOND, Frame
from rtgen.runtime.failures import log
from rtgen.runtime.timing.stepping_aside import step_aside

_QUEUE: Final = 4096
"""Capacity of the transmit queue in frames."""
_BATCH: Final = 64
"""Maximum number of frames received before they are delivered."""
_LOCAL_BURST: Final = 16384
"""Maximum number of frames exchanged within the process in response to one frame."""
_POLL_INTERVAL: Final = 0.05
"""Period in seconds at which a waiting thread checks whether the link is closed."""
_FLUSH_TIMEOUT: Final = 1.0
"""Time-out in seconds for sending queued frames when the link is closed."""
_FIRST_DELAY, _MAX_DELAY = 0.1, 2.0
"""Seconds between attempts to reopen a lost bus: the first, and the maximum."""


class RealLink(SharedLink):
    """A process's link to a python-can bus, for all its stations.

    Reception and transmission have a thread each, because a bus may block anywhere; timers are
    called by the first one, or have their own while the bus is lost, and for buses without a
    descriptor. Stations are called in the thread with an event for them, with `lock` held. A lost
    bus is reopened, with increasing delays. Time is the machine's monotonic clock.
    """

    def __init__(
        self,
        address: BusAddress,
        on_attached: Callable[[], None],
        may_close: Callable[[], bool],
    ) -> None:
        """Open the bus. Raises LinkError.

        `on_attached` is called for every station; `may_close` after the last one has been detached.
        """
        super().__init__(str(address))
        self.address = address
        self._on_attached = on_attached
        self._may_close = may_close
        self.ignored = 0
        """Messages that were not frames of classical CAN and reported no change of the bus."""
        bus = open_bus(address)
        self._bus: OpenBus | None = bus
        self.carries_remote_frames = bus.carries_remote_frames
        self._up = True
        self._closing = threading.Event()
        self._lock = threading.RLock()
        self._news = threading.Condition(self._lock)
        self._waiters = 0
        self._alarm = threading.Event()
        self._alarm_at: int | None = None
        self._outgoing: SimpleQueue[Frame | None] = SimpleQueue()
        self._local: deque[tuple[Frame, AttachedStation | None]] = deque()
        self._delivering = False
        self._failure: LinkError | None = None
        """Why the bus is unusable, as detected by the transmitting thread."""
        self._threads: tuple[threading.Thread, ...] = ()
        self._bell = None if bus.descriptor is None else Bell(bus.descriptor)
        """Wakes the thread that receives, if that calls timers, too."""
        self._start("receive", self._receive)
        self._start("transmit", self._transmit)
        if self._bell is None:
            self._start("timers", self._watch_time)

    def _start(self, what: str, run: Callable[[], None]) -> threading.Thread:
        name = f"rtgen {self.address} {what}"
        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads += (thread,)
        thread.start()
        return thread

    @property
    def lock(self) -> AbstractContextManager[object]:
        """See `Link`."""
        return self._lock

    @property
    def up(self) -> bool:
        """See `Link`."""
        return self._up

    @property
    def closed(self) -> bool:
        """Whether the link is closed permanently."""
        return self._closing.is_set()

    def now(self) -> int:
        """See `Link`."""
        return time.monotonic_ns()

    def attach(self, station: Station) -> None:
        """See `SharedLink`. Raises LinkError if the link is closed."""
        with self._lock:
            if self.closed:
                raise LinkError(f"{self.bus} is closed")
            super().attach(station)
        self._on_attached()

    def wait(self, until: Callable[[], bool], timeout: int) -> bool:
        """See `Link`."""
        if threading.current_thread() in self._threads:
            raise RuntimeError("a station must not wait for its link")
        step_aside()
        end = self.now() + timeout
        with self._news:
            self._waiters += 1
            try:
                while not until():
                    rest = end - self.now()
                    if rest <= 0 or self.closed:
                        return False
                    # The condition may depend on other events, too.
                    self._news.wait(min(rest / SECOND, _POLL_INTERVAL))
                return True
            finally:
                self._waiters -= 1

    def close(self) -> None:
        """Send queued frames, then end the threads and close the bus.

        Called when the last station is detached; call it directly only for a link without stations.
        """
        if self.closed:
            return
        self._closing.set()
        self._outgoing.put(None)
        self._ring()
        if threading.current_thread() in self._threads:
            threading.Thread(target=self._end, name=f"rtgen {self.bus} end").start()
        else:
            self._end()

    def _close(self) -> None:
        if self._may_close():
            self.close()

    def _end(self) -> None:
        transmit = self._threads[1]
        transmit.join(_FLUSH_TIMEOUT)
        bus = self._bus
        if transmit.is_alive() and bus is not None:
            bus.interrupt()
        for thread in self._threads:
            thread.join()
        if self._bell is not None:
            self._bell.close()
        if self._bus is not None:
            self._bus.close()
            self._bus = None
        self._up = False

    # Transmission

    def _put(self, frames: Iterable[Frame], attached: AttachedStation | None) -> None:
        bus = self._bus
        for frame in frames:
            if not self._up or self.closed or self._outgoing.qsize() >= _QUEUE:
                self.lost += 1
                continue
            self._outgoing.put(frame)
            if bus is not None and bus.on_queued is not None:
                bus.on_queued(frame)
            self._local.append((frame, attached))
        if not self._delivering:
            self._deliver()

    def _deliver(self) -> None:
        """Deliver sent frames to the other stations of this process."""
        self._delivering = True
        try:
            for _ in range(_LOCAL_BURST):
                if not self._local:
                    return
                frame, attached = self._local.popleft()
                self._give(frame, attached, self.now())
            log.warning("%s: its stations answer each other without end", self.bus)
            self._local.clear()
        finally:
            self._delivering = False
            self._notice()

    def _notice(self) -> None:
        """Update timers and wake waiting threads after calls of stations."""
        self._timers_changed()
        if self._waiters:
            self._news.notify_all()

    def _timers_changed(self) -> None:
        deadline = self._attached.deadline
        if deadline is not None and (
            self._alarm_at is None or deadline < self._alarm_at
        ):
            self._alarm_at = deadline
            self._ring()

    def _ring(self) -> None:
        self._alarm.set()
        if (
            self._bell is not None
            and threading.current_thread() is not self._threads[0]
        ):
            self._bell.ring()

    def _failed(self, attached: AttachedStation, error: Exception) -> None:
        log.error("%s: %r failed", self.bus, attached.station, exc_info=error)

    # Threads

    def _enter(self) -> bool:
        """Acquire the lock; False if the link is closed, even if another thread holds the lock."""
        while not self._lock.acquire(timeout=_POLL_INTERVAL):
            if self.closed:
                return False
        if self.closed:
            self._lock.release()
            return False
        return True

    def _receive(self) -> None:
        while (bus := self._bus) is not None and not self.closed:
            try:
                while not self.closed:
                    self._receive_from(bus)
            except LinkError as error:
                self._open_again(bus, error)

    def _receive_from(self, bus: OpenBus) -> None:
        seconds = _POLL_INTERVAL
        if self._bell is not None:
            seconds = 0.0
            rest = self._call_timers()
            if rest > 0 and not bus.has_received:
                self._bell.wait(rest)
        events = bus.receive_events(seconds, _BATCH)
        if self._failure is not None:
            raise self._failure
        if not events and not self._up and bus.has_returned:
            self._turn_all(True)
        frames: list[Frame] = []
        for event in events:
            if isinstance(event, Frame):
                frames.append(event)
            elif event is None:
                self.ignored += 1
            else:
                self._take(frames)
                frames.clear()
                self._turn_all(not event)
        self._take(frames)

    def _take(self, frames: list[Frame]) -> None:
        """Deliver received frames to the stations."""
        if not frames or not self._enter():
            return
        try:
            if not self._up:
                self._turn_all(True)
            self._local += [(frame, None) for frame in frames]
            self._deliver()
        finally:
            self._lock.release()

    def _open_again(self, bus: OpenBus, error: LinkError) -> None:
        log.warning("%s; it is tried again", error)
        self._turn_all(False)
        self._bus = None
        if self._bell is None:
            self._await_bus(bus)
            return
        self._bell.leave()
        before = self._threads
        timers = self._start("timers", self._watch_time)
        self._await_bus(bus)
        self._alarm.set()
        timers.join()
        self._threads = before
        if self._bus is not None and self._bus.descriptor is not None:
            self._bell.join(self._bus.descriptor)

    def _await_bus(self, bus: OpenBus) -> None:
        """Open a lost bus again, unless the link is closed before."""
        bus.interrupt()
        bus.close()
        pause = _FIRST_DELAY
        while not self._closing.wait(pause):
            try:
                self._bus = open_bus(self.address)
            except LinkError:
                pause = min(2 * pause, _MAX_DELAY)
                continue
            self._failure = None
            log.warning("%s: open again", self.bus)
            self._turn_all(True)
            return

    def _turn_all(self, up: bool) -> None:
        """Notify all stations that the bus is lost or available again."""
        if not self._enter():
            return
        try:
            self._up = up
            for attached in self._attached:
                self._turn(attached, up, self.now())
            self._notice()
        finally:
            self._lock.release()

    def _transmit(self) -> None:
        while (frame := self._outgoing.get()) is not None:
            bus = self._bus
            if bus is None or not self._up:
                self.lost += 1
                continue
            try:
                self.lost += not bus.send(frame)
            except LinkError as error:
                self.lost += 1
                self._failure = error

    def _watch_time(self) -> None:
        while self._enter():
            try:
                if self._bell is not None and self._bus is not None:
                    return  # it is open again
                deadline = self._attached.deadline
                now = self.now()
                if deadline is not None and deadline <= now:
                    self._poll(now)
                    self._notice()
                    continue
                self._alarm.clear()
                self._alarm_at = deadline
            finally:
                self._lock.release()
            self._alarm.wait(None if deadline is None else (deadline - now) / SECOND)

    def _call_timers(self) -> float:
        """Call the timers that are due; return the seconds until others are."""
        if not self._enter():
            return 0.0
        try:
            now = self.now()
            deadline = self._attached.deadline
            if deadline is not None and deadline <= now:
                self._poll(now)
                self._notice()
                deadline = self._attached.deadline
            self._alarm_at = deadline
        finally:
            self._lock.release()
        if deadline is None:
            return _POLL_INTERVAL
        return min(_POLL_INTERVAL, (deadline - now) / SECOND)
