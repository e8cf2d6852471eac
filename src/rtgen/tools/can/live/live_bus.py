"""Opens a python-can bus and delivers its frames while a command runs."""

from __future__ import annotations

import queue
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING, Final, cast

from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.canopen.bus.python_can import OpenBus, open_bus
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import SECOND, Frame
from rtgen.runtime.timing.steady import steady_utc
from rtgen.tools.can.access import BusAccess
from rtgen.tools.can.common import require_python_can
from rtgen.tools.kit.signals import handled, terminable

if TYPE_CHECKING:
    from can import BusABC, Message

TICK: Final = 0.2
"""Seconds after which the iteration yields None if no frame comes."""

_NOTIFIER_TIMEOUT: Final = 0.05
"""Seconds that the notifier waits for a frame; stopping it takes as long."""
_MAX_WAITING: Final = 1 << 18
"""Capacity of the queue between the notifier and the command, in frames."""
_LINGER: Final = 0.05
"""Seconds that the last frame sent has to leave the interface."""
_ATTEMPTS: Final = 100
_RETRY_INTERVAL: Final = 0.01
"""Seconds between two attempts to send while the interface's queue is full."""


@contextmanager
def opened(access: BusAccess) -> Iterator[OpenBus]:
    """Open the bus and close it at the end. Raises ToolError if it cannot be opened."""
    require_python_can()
    try:
        bus = open_bus(access.address())
    except LinkError as error:
        raise ToolError(f"cannot open the bus: {error}") from error
    try:
        yield bus
    finally:
        bus.close()


class _Receiving:
    """Adapts a bus to python-can's Notifier, which then stops when the bus does."""

    def __init__(self, bus: OpenBus) -> None:
        self.recv = bus.receive
        self.channel_info = bus.bus.channel_info

    def fileno(self) -> int:
        """Not available: the notifier falls back to a thread."""
        raise NotImplementedError


class FrameIterator:
    """Iterator over received frames, which yields None at least every `TICK` seconds.

    A python-can notifier fills its queue from a thread; `lost` counts frames that found the queue
    full. The iterator ends after `seconds` or `count` frames, or at Ctrl-C, which does not
    interrupt its consumer. Raises ToolError if the bus is lost.
    """

    def __init__(
        self, seconds: float | None, count: int | None, ended: threading.Event
    ) -> None:
        self._end = None if seconds is None else time.monotonic() + seconds
        self._left = count
        self._ended = ended
        self._waiting: queue.Queue[Message | Exception] = queue.Queue(_MAX_WAITING)
        self.lost = 0

    def __call__(self, message: Message) -> None:
        """Queue a frame (called by the notifier)."""
        try:
            self._waiting.put_nowait(message)
        except queue.Full:
            self.lost += 1

    def on_error(self, error: Exception) -> None:
        """Queue an error of the bus (called by the notifier)."""
        if not self._waiting.full():
            self._waiting.put_nowait(error)
        time.sleep(_NOTIFIER_TIMEOUT)

    def __iter__(self) -> Iterator[Message | None]:
        return self

    def __next__(self) -> Message | None:
        remaining = (
            TICK if self._end is None else min(self._end - time.monotonic(), TICK)
        )
        if self._left == 0 or remaining <= 0 or self._ended.is_set():
            raise StopIteration
        try:
            message = self._waiting.get(timeout=remaining)
        except queue.Empty:
            return None
        if isinstance(message, Exception):
            raise ToolError(f"the bus is gone: {message}") from message
        if self._left is not None:
            self._left -= 1
        if not message.timestamp:
            message.timestamp = steady_utc() / SECOND
        return message


@contextmanager
def frames(
    bus: OpenBus, seconds: float | None = None, count: int | None = None
) -> Iterator[FrameIterator]:
    """The frames of a bus, for some seconds or a number of frames."""
    from can import Notifier

    with _noted_signals() as ended:
        received = FrameIterator(seconds, count, ended)
        receiving = cast("BusABC", _Receiving(bus))
        notifier = Notifier(receiving, [received], timeout=_NOTIFIER_TIMEOUT)
        try:
            yield received
        finally:
            notifier.stop()


@contextmanager
def drained(bus: OpenBus) -> Iterator[None]:
    """Receive and drop all frames: some peers block while nobody reads from them.

    On leaving, waits until the last frame sent has left the interface.
    """
    from can import Notifier

    notifier = Notifier(
        cast("BusABC", _Receiving(bus)), [_Drain()], timeout=_NOTIFIER_TIMEOUT
    )
    try:
        yield
        time.sleep(_LINGER)
    finally:
        notifier.stop()


class _Drain:
    """A listener that drops all frames."""

    def __call__(self, message: Message) -> None:
        """Drop a frame."""

    def on_error(self, error: Exception) -> None:
        """Ignore an error of the bus, which the sender notices itself."""
        time.sleep(_NOTIFIER_TIMEOUT)


@contextmanager
def _noted_signals() -> Iterator[threading.Event]:
    """An event set by Ctrl-C or SIGTERM; a second signal raises KeyboardInterrupt."""
    ended = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    with handled(note, signal.SIGINT, signal.SIGTERM):
        yield ended


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Leave the block normally at Ctrl-C or SIGTERM."""
    with suppress(KeyboardInterrupt), terminable():
        yield


def can_carry(bus: OpenBus, frame: Frame) -> bool:
    """Return whether the interface can send the frame; socketcand has no remote frames."""
    return not frame.remote or bus.carries_remote_frames


def send(bus: OpenBus, frame: Frame) -> None:
    """Send a frame, waiting while the interface's queue is full. Raises ToolError if it fails."""
    if not can_carry(bus, frame):
        raise ToolError("the protocol of socketcand has no remote frames")
    for _ in range(_ATTEMPTS):
        try:
            if bus.send(frame):
                return
        except LinkError as error:
            raise ToolError(f"the bus is gone: {error}") from error
        time.sleep(_RETRY_INTERVAL)
    raise ToolError("cannot send: the interface has no room", "is the bus connected?")
