"""Client of a hub: a python-can bus for the protocol of socketcand in raw mode.

python-can's own client loops on a connection closed by the hub, and sets a socket option for each
frame.
"""

from __future__ import annotations

import socket
from collections import deque
from typing import Final

import can

from rtgen.runtime.canopen.bus.hub_text import (
    Elements,
    Malformed,
    received_error,
    received_frame,
    send_text,
)
from rtgen.runtime.canopen.bus.messages import frame_of, message_of
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.sockets import TIME_OVER, limit_receives, limit_times

_TIMEOUT: Final = 2.0
"""Time-out in seconds of the hub's answers, and of sending a frame to it."""
_CHUNK: Final = 65536
_FOREVER: Final = 1e6
_DO_NOT_WAIT: Final = getattr(socket, "MSG_DONTWAIT", 0)


class SocketcandBus(can.BusABC):
    """A connection to a channel of a hub. One thread can send while another one receives."""

    def __init__(self, channel: str, host: str, port: int) -> None:
        """Connect. Raises OSError, and CanError with the hub's answer if the hub refuses."""
        self._elements = Elements()
        self._limit = _TIMEOUT
        self._received: deque[tuple[Frame | int, float]] = deque()
        self.malformed = 0
        """Number of received texts that were not frames."""
        self.channel = channel
        self.channel_info = f"socketcand {channel} at {host}:{port}"
        self._socket = socket.create_connection((host, port), _TIMEOUT)
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            limit_times(self._socket, _TIMEOUT)
            self._expect("< hi >")
            for command in (f"open {channel}", "rawmode"):
                self._socket.sendall(f"< {command} >".encode())
                self._expect("< ok >")
        except BaseException:
            self._socket.close()
            raise
        super().__init__(channel)

    def _expect(self, expected: str) -> None:
        try:
            answer = self._answer()
        except TIME_OVER as error:
            raise can.CanTimeoutError("no answer") from error
        except Malformed as error:
            answer = str(error)
        if answer != expected:
            raise can.CanInitializationError(f"the hub replied {answer!r}")

    def _answer(self) -> str:
        while (words := self._elements.take()) is None:
            data = self._socket.recv(_CHUNK)
            if not data:
                return "nothing"
            self._elements.feed(data)
        return f"< {words} >"

    def receive(self, timeout: float) -> tuple[Frame | int, float] | None:
        """Return the next frame, or class of an error frame, with its time stamp in s.

        None if there is none within `timeout` s. Raises OSError and CanOperationError.
        """
        if not self._received:
            self._read(timeout)
        return self._received.popleft() if self._received else None

    def fileno(self) -> int:
        """Return the descriptor of the connection."""
        return self._socket.fileno()

    @property
    def has_received(self) -> bool:
        """Whether `receive` returns without reading."""
        return bool(self._received)

    def transmit(self, frame: Frame) -> None:
        """Send a data frame; its text is written completely or not at all."""
        if frame.remote:
            raise can.CanOperationError("the protocol has no remote frames")
        text = send_text(frame)
        sent = self._socket.send(text)
        if sent < len(text):
            try:
                self._socket.sendall(text[sent:])
            except TIME_OVER as error:
                self.interrupt()
                raise can.CanOperationError("the hub has not read a frame") from error

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        received = self.receive(_FOREVER if timeout is None else timeout)
        if received is None:
            return None, False
        content, seconds = received
        message = (
            can.Message(seconds, is_error_frame=True, arbitration_id=content)
            if (isinstance(content, int))
            else message_of(content, seconds)
        )
        message.channel = self.channel
        return message, False

    def _read(self, seconds: float) -> None:
        flags = 0
        if seconds <= 0 and _DO_NOT_WAIT:
            flags = _DO_NOT_WAIT
        elif seconds != self._limit:
            limit_receives(self._socket, seconds)
            self._limit = seconds
        try:
            data = self._socket.recv(_CHUNK, flags)
        except TIME_OVER:
            return
        if not data:
            raise can.CanOperationError("the other end has closed the connection")
        self._elements.feed(data)
        while True:
            received = self._elements.take_received()
            if received is not None:
                self._received.append(received)
                continue
            try:
                words = self._elements.take()
                if words is None:
                    return
                if words.startswith("frame "):
                    self._received.append(received_frame(words))
                else:
                    self._received.append(received_error(words))
            except Malformed:
                self.malformed += 1

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """See `transmit`; error frames and frames of CAN FD raise CanOperationError, too."""
        frame = frame_of(msg)
        if frame is None:
            raise can.CanOperationError("the protocol has frames of classical CAN only")
        self.transmit(frame)

    def interrupt(self) -> None:
        """Close the connection: blocking calls in other threads return."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # The other end has disconnected, so nothing blocks.
            return

    def shutdown(self) -> None:
        """Close the connection."""
        super().shutdown()
        self._socket.close()
