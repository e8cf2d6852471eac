"""Frames of a python-can bus, as long as a command wants them."""

from __future__ import annotations

import logging
import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING, Any, Final

from rtgen.cli.can.common import require_python_can
from rtgen.cli.can.options import BusAccess
from rtgen.diagnostics import ToolError
from rtgen.runtime.canopen.frames import Frame

if TYPE_CHECKING:
    from can import BusABC, Message

TICK: Final = 0.2
"""Seconds after which an iteration goes on without a frame."""

_NOTIFIER: Final = 0.1
"""Seconds that the notifier waits for a frame, and so that it takes to stop."""
_MAX_WAITING: Final = 1 << 18
"""Frames that may wait for the command."""


@contextmanager
def opened(access: BusAccess) -> Iterator[BusABC]:
    """The bus, shut down at the end. Raises ToolError if it cannot be used."""
    require_python_can()
    import can

    _silence()
    try:
        further: dict[str, Any] = access.arguments
        bus = can.Bus(interface=access.interface, channel=access.channel, **further)
    except can.CanInterfaceNotImplementedError as error:
        hint: str | None = "give --interface, for instance --interface socketcan --channel can0"
        if access.interface is not None:
            hint = f"python-can has {', '.join(sorted(can.VALID_INTERFACES))}"
        raise ToolError(f"no such interface: {_said(error)}", hint) from error
    except (can.CanError, OSError, ValueError, TypeError, ImportError) as error:
        hint = "is the hub running? rtgen can hub" if _for_hub(access) else None
        raise ToolError(f"cannot open {access}: {_said(error)}", hint) from error
    try:
        yield bus
    finally:
        bus.shutdown()


def _said(error: BaseException) -> str:
    return " ".join(f"{error}".split()) or type(error).__name__


def _for_hub(access: BusAccess) -> bool:
    return access.interface == "socketcand"


def _silence() -> None:
    """Keeps python-can's log records off standard error: what matters is raised, too."""
    log = logging.getLogger("can")
    if not log.handlers:
        log.addHandler(logging.NullHandler())
        log.propagate = False


class Inbox:
    """Takes frames from a bus by a python-can notifier, in a thread, till it is closed.

    `lost` counts frames that came while too many waited.
    """

    def __init__(self, bus: BusABC) -> None:
        from can import Notifier

        self._bus = bus
        self._waiting: queue.Queue[Message | Exception] = queue.Queue(_MAX_WAITING)
        self.lost = 0
        self._notifier = Notifier(bus, [self], timeout=_NOTIFIER)

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

    def take(self, timeout: float) -> Message | None:
        """The next frame, None if none comes in time. Raises ToolError if the bus is gone."""
        try:
            found = self._waiting.get(timeout=max(timeout, 0.0))
        except queue.Empty:
            if _gone(self._bus):
                raise ToolError("the bus is gone: the peer has closed") from None
            return None
        if isinstance(found, Exception):
            raise ToolError(f"the bus has failed: {_said(found)}") from found
        return found

    def close(self) -> None:
        """Takes no more frames."""
        self._notifier.stop()


@contextmanager
def inbox(bus: BusABC) -> Iterator[Inbox]:
    """An inbox that is closed at the end."""
    made = Inbox(bus)
    try:
        yield made
    finally:
        made.close()


def frames(
    source: Inbox, seconds: float | None = None, count: int | None = None
) -> Iterator[Message | None]:
    """Frames until the time is over, there are so many, or Ctrl-C; None now and then.

    The one who iterates is not interrupted. Raises ToolError if the bus is gone.
    """
    end = None if seconds is None else time.monotonic() + seconds
    with _noted_signals() as ended:
        yield from _frames(source, end, count, ended)


def _frames(
    source: Inbox, end: float | None, count: int | None, ended: threading.Event
) -> Iterator[Message | None]:
    found = 0
    while not ended.is_set() and (count is None or found < count):
        left = TICK if end is None else min(end - time.monotonic(), TICK)
        if left <= 0:
            return
        message = source.take(left)
        found += message is not None
        yield message


@contextmanager
def _noted_signals() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set; the second one interrupts as ever."""
    ended = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    with _handled(note, signal.SIGINT, signal.SIGTERM):
        yield ended


@contextmanager
def _handled(
    handler: Callable[[int, FrameType | None], None], *numbers: signal.Signals
) -> Iterator[None]:
    """Handles signals, which only the main thread can."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = [(number, signal.signal(number, handler)) for number in numbers]
    try:
        yield
    finally:
        for number, old in before:
            signal.signal(number, old)


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Ends the block at Ctrl-C, and at SIGTERM, as if it were over."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    with suppress(KeyboardInterrupt), _handled(interrupt, signal.SIGTERM):
        yield


def frame_of(message: Message) -> Frame | None:
    """The frame of a message; None for an error frame and for one of CAN FD."""
    if message.is_error_frame or message.is_fd:
        return None
    return Frame(
        message.arbitration_id,
        b"" if message.is_remote_frame else bytes(message.data),
        message.is_remote_frame,
        message.is_extended_id,
    )


def message_of(frame: Frame) -> Message:
    """The message of a frame."""
    from can import Message

    return Message(
        arbitration_id=frame.can_id,
        data=None if frame.remote else frame.data,
        is_remote_frame=frame.remote,
        is_extended_id=frame.extended,
        is_rx=False,
    )


def send(bus: BusABC, frame: Frame) -> None:
    """Sends a frame. Raises ToolError if the bus is gone."""
    send_message(bus, message_of(frame))


def send_message(bus: BusABC, message: Message) -> None:
    """Sends a message. Raises ToolError if the bus is gone."""
    from can import CanError

    try:
        bus.send(message, timeout=1.0)
    except (CanError, OSError, ValueError) as error:
        raise ToolError(f"cannot send: {_said(error)}") from error


def _gone(bus: BusABC) -> bool:
    """Whether the peer of a socketcand bus has closed: python-can then reads nothing, forever."""
    import socket

    peer = getattr(bus, "_SocketCanDaemonBus__socket", None)
    if peer is None:
        return False
    try:
        return not peer.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
    except BlockingIOError:
        return False
    except OSError:
        return True
