"""A python-can bus in simulated time, for python-can's readers, loggers and cyclic tasks.

Nothing blocks and there are no threads: `Notifier` and `send_periodic` are replaced by the
system's clock.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Final

import can
from can.broadcastmanager import (
    LimitedDurationCyclicSendTaskABC,
    ModifiableCyclicTaskABC,
    RestartableCyclicTaskABC,
)

from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.messages import frame_of, message_of
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.timing.clocks import SECOND, Clock

Recipient = Callable[[can.Message], object]

_QUEUE: Final = 1 << 20
"""Maximum number of messages buffered for `recv`; the oldest are dropped."""


class SimulatedBus(can.BusABC):
    """A python-can bus on a channel in simulated time.

    Time stamps are seconds of simulated time. `recv` does not block: it delivers queued frames, and
    returns None if none is for this bus. Use `add_listener` for a `can.Listener` instead of a
    `Notifier`.
    """

    def __init__(
        self, owner: Component | Clock, channel: str = "can0", bitrate: int = 0
    ) -> None:
        """Join the channel as `open_link` does. Raises LinkError."""
        link = open_link(owner, "simulated", channel, bitrate)
        self.channel = channel
        self.channel_info = f"simulated CAN bus {channel}"
        self._can_protocol = can.CanProtocol.CAN_20
        self._station = _Station(link, self)
        link.attach(self._station)
        super().__init__(channel)

    @property
    def dropped(self) -> int:
        """Number of messages dropped because `recv` was not called."""
        return self._station.dropped

    def add_listener(self, listener: Recipient) -> None:
        """Call a listener for each message; messages are then not buffered for `recv`."""
        self._station.listeners.append(listener)

    def remove_listener(self, listener: Recipient) -> None:
        """Remove a listener. Raises ValueError if it was not added."""
        self._station.listeners.remove(listener)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queue a message. Raises CanOperationError if the bus is off, or for CAN FD."""
        frame = _frame(msg)
        station = self._station
        try:
            station.link.send([frame], station)
        except LinkError as error:
            raise can.CanOperationError(str(error)) from error

    def shutdown(self) -> None:
        """Leave the bus."""
        super().shutdown()
        self._station.link.detach(self._station)

    @property
    def state(self) -> can.BusState:
        """ERROR while the bus is off, else ACTIVE."""
        return can.BusState.ACTIVE if self._station.up else can.BusState.ERROR

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        raise NotImplementedError("the link reports the state")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        messages = self._station.messages
        if not messages:
            self._station.link.wait(lambda: bool(messages), 0)
        return (messages.popleft() if messages else None), False

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next message; None if there is none, since no time passes."""
        return super().recv(0)

    def _send_periodic_internal(
        self,
        msgs: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None = None,
        autostart: bool = True,
        modifier_callback: Callable[[can.Message], None] | None = None,
    ) -> SimulatedCyclicTask:
        task = SimulatedCyclicTask(
            self._station, msgs, period, duration, modifier_callback
        )
        if autostart:
            task.start()
        return task


class SimulatedCyclicTask(
    LimitedDurationCyclicSendTaskABC, ModifiableCyclicTaskABC, RestartableCyclicTaskABC
):
    """Messages sent periodically, in rotation, on the clock of the link."""

    def __init__(
        self,
        station: _Station,
        messages: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None,
        modifier: Callable[[can.Message], None] | None,
    ) -> None:
        super().__init__(messages, period, duration)
        if self.period_ns <= 0:
            raise ValueError(f"a period of {period} s")
        self.due = 0
        self._station = station
        self._modifier = modifier
        self._sent = 0
        self._end: int | None = None

    def start(self) -> None:
        """Start, or restart, now."""
        now = self._station.link.now()
        self.due = now
        self._end = (
            None if self.duration is None else now + round(self.duration * SECOND)
        )
        self._station.tasks[self] = None
        self._station.changed()

    def stop(self) -> None:
        """Stop; does nothing for a task that has ended."""
        self._station.tasks.pop(self, None)
        self._station.changed()

    def next_frame(self) -> Frame | None:
        """Return the frame that is due; None if the task has ended."""
        if self._end is not None and self.due >= self._end:
            self._station.tasks.pop(self, None)
            return None
        message = self.messages[self._sent % len(self.messages)]
        if self._modifier is not None:
            self._modifier(message)
        self._sent += 1
        self.due += self.period_ns
        return _frame(message)


class _Station:
    """The bus's station at its link."""

    identifiers = None

    def __init__(self, link: Link, bus: SimulatedBus) -> None:
        self.link = link
        self.up = link.up
        self.dropped = 0
        self.tasks: dict[SimulatedCyclicTask, None] = {}
        self.listeners: list[Recipient] = []
        self.messages: deque[can.Message] = deque()
        self._bus = bus

    @property
    def deadline(self) -> int | None:
        return min((task.due for task in self.tasks), default=None)

    def changed(self) -> None:
        self.link.refresh(self)

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        message = message_of(frame)
        message.timestamp = now / SECOND
        message.channel = self._bus.channel
        message.is_rx = True
        if self.listeners:
            if self._bus._matches_filters(message):
                for listener in tuple(self.listeners):
                    listener(message)
            return ()
        self.messages.append(message)
        if len(self.messages) > _QUEUE:
            self.messages.popleft()
            self.dropped += 1
        return ()

    def poll(self, now: int) -> Iterable[Frame]:
        due = [task for task in self.tasks if task.due <= now]
        frames = [task.next_frame() for task in due]
        return [frame for frame in frames if frame is not None]

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        self.up = up
        return ()


def _frame(message: can.Message) -> Frame:
    frame = frame_of(message)
    if frame is None:
        raise can.CanOperationError(f"no frame of classical CAN: {message}")
    return frame
