"""Frames of a python-can bus, as long as a command wants them."""

from __future__ import annotations

import queue
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING, Final, cast

from rtgen.cli.can.common import require_python_can
from rtgen.cli.can.options import BusAccess
from rtgen.cli.signals import handled, terminable
from rtgen.diagnostics import ToolError
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.frames import Frame
from rtgen.runtime.canopen.python_can import OpenBus, open_bus

if TYPE_CHECKING:
    from can import BusABC, Message

TICK: Final = 0.2
"""Seconds after which an iteration goes on without a frame."""

_NOTIFIER: Final = 0.05
"""Seconds that the notifier waits for a frame, and so that it takes to stop."""
_MAX_WAITING: Final = 1 << 18
"""Frames that may wait for the command."""
_LINGER: Final = 0.05
"""Seconds that the last frame has to leave."""
_ATTEMPTS: Final = 100
_PAUSE: Final = 0.01
"""Seconds between two attempts to send what the interface has no room for."""


@contextmanager
def opened(access: BusAccess) -> Iterator[OpenBus]:
    """The bus, closed at the end. Raises ToolError if it cannot be used."""
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
    """A bus as python-can's notifier takes it, which ends when the bus does."""

    def __init__(self, bus: OpenBus) -> None:
        self.recv = bus.receive
        self.channel_info = bus.bus.channel_info

    def fileno(self) -> int:
        """The notifier has a thread."""
        raise NotImplementedError


class Coming:
    """Frames that come from a bus, as an iterator that gives None now and then.

    A python-can notifier takes them in a thread; `lost` counts those that came while too many
    waited. It ends when the time is over, at the count of frames, or at Ctrl-C, which does not
    interrupt the one who iterates. Raises ToolError if the bus is gone.
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
        """Takes a frame: called by the notifier."""
        try:
            self._waiting.put_nowait(message)
        except queue.Full:
            self.lost += 1

    def on_error(self, error: Exception) -> None:
        """The bus has failed: called by the notifier."""
        if not self._waiting.full():
            self._waiting.put_nowait(error)
        time.sleep(_NOTIFIER)

    def __iter__(self) -> Iterator[Message | None]:
        return self

    def __next__(self) -> Message | None:
        left = TICK if self._end is None else min(self._end - time.monotonic(), TICK)
        if self._left == 0 or left <= 0 or self._ended.is_set():
            raise StopIteration
        try:
            found = self._waiting.get(timeout=left)
        except queue.Empty:
            return None
        if isinstance(found, Exception):
            raise ToolError(f"the bus is gone: {found}") from found
        if self._left is not None:
            self._left -= 1
        if not found.timestamp:
            found.timestamp = time.time()
        return found


@contextmanager
def frames(
    bus: OpenBus, seconds: float | None = None, count: int | None = None
) -> Iterator[Coming]:
    """The frames of a bus, for so long or so many."""
    from can import Notifier

    with _noted_signals() as ended:
        coming = Coming(seconds, count, ended)
        receiving = cast("BusABC", _Receiving(bus))
        notifier = Notifier(receiving, [coming], timeout=_NOTIFIER)
        try:
            yield coming
        finally:
            notifier.stop()


@contextmanager
def drained(bus: OpenBus) -> Iterator[None]:
    """Takes what comes, and drops it: a peer must not wait for one who only sends.

    At the end what was sent is on its way.
    """
    from can import Notifier

    notifier = Notifier(cast("BusABC", _Receiving(bus)), [_Drain()], timeout=_NOTIFIER)
    try:
        yield
        time.sleep(_LINGER)
    finally:
        notifier.stop()


class _Drain:
    """Drops frames."""

    def __call__(self, message: Message) -> None:
        """Drops a frame."""

    def on_error(self, error: Exception) -> None:
        """The bus has failed: the one who sends notices."""
        time.sleep(_NOTIFIER)


@contextmanager
def _noted_signals() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set; the second one interrupts as ever."""
    ended = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    with handled(note, signal.SIGINT, signal.SIGTERM):
        yield ended


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Ends the block at Ctrl-C, and at SIGTERM, as if it were over."""
    with suppress(KeyboardInterrupt), terminable():
        yield


def can_carry(bus: OpenBus, frame: Frame) -> bool:
    """Whether the interface can send the frame: socketcand's protocol has no remote frames."""
    return not frame.remote or type(bus.bus).__name__ != "SocketCanDaemonBus"


def send(bus: OpenBus, frame: Frame) -> None:
    """Sends a frame; waits if the interface has no room. Raises ToolError if it cannot be sent."""
    if not can_carry(bus, frame):
        raise ToolError("python-can's interface socketcand sends no remote frames")
    for _ in range(_ATTEMPTS):
        try:
            if bus.send(frame):
                return
        except LinkError as error:
            raise ToolError(f"the bus is gone: {error}") from error
        time.sleep(_PAUSE)
    raise ToolError("cannot send: the interface has no room", "is the bus connected?")
