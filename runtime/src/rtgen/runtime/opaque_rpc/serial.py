"""OpaqueRPC over a serial line: a channel for callers, and a server. Needs pyserial.

A line has no connections to close. After an error both ends discard input until the line is silent,
then wait for the start of a message. OpaqueRPC has no check sum, so noise that looks like a
complete message is accepted.
"""

from __future__ import annotations

import errno
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from rtgen.facts.extras import installation
from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc.ends import ConnectedChannel, ConnectedServer
from rtgen.runtime.opaque_rpc.errors import E_OBJ, E_TMOUT, ChannelError
from rtgen.runtime.opaque_rpc.messages import MessageReader, Service, log, serve, starts
from rtgen.runtime.opaque_rpc.tdr import SOP_REPLY, SOP_REQUEST

if TYPE_CHECKING:
    from serial import Serial

_TERMINAL_ERRORS: tuple[type[Exception], ...] = ()
if sys.platform != "win32":
    import termios

    _TERMINAL_ERRORS = (termios.error,)

BAUDRATE = 115200
_BITS = 10
"""Bits per character on the line: start, 8 data bits, stop."""
_SILENCE = 0.02
_SILENT_CHARACTERS = 30
_BLOCK = 4096
_POLL_INTERVAL = 0.2
"""Period [s] at which a waiting server checks whether it was closed."""
_SHARED_HEAD = 4
"""Offset of the request on a shared channel."""


def silence(baudrate: int) -> float:
    """Return how long [s] a line must be silent after an error: 20 ms or 30 characters."""
    return max(_SILENCE, _SILENT_CHARACTERS * _BITS / baudrate)


def _reply_start(request: bytes) -> bytes:
    """Return the start of the reply to a request: both have the same byte order."""
    big = SOP_REQUEST.to_bytes(2, "big")
    starts = (request[:2], request[_SHARED_HEAD : _SHARED_HEAD + 2])
    return SOP_REPLY.to_bytes(2, "big" if big in starts else "little")


@contextmanager
def _as_os_errors() -> Iterator[None]:
    """Convert errors of the terminal driver, which pyserial passes on, to OSError."""
    try:
        yield
    except _TERMINAL_ERRORS as error:
        raise OSError(*error.args) from error


def _reason(error: Exception) -> str:
    """Return why a device cannot be opened, without repetitions in pyserial's messages."""
    number = getattr(error, "errno", None)
    if number in (errno.EAGAIN, errno.EBUSY):
        return "it is in use"
    return os.strerror(number) if number else str(error)


class _Line:
    """An open serial line, 8N1 without flow control, not shared with other processes."""

    def __init__(self, device: str, baudrate: int) -> None:
        try:
            from serial import Serial
        except ImportError as error:
            raise ChannelError(
                E_OBJ, f"serial lines need pyserial: {installation('serial')}"
            ) from error
        self._silence = silence(baudrate)
        self._closing = threading.Lock()
        try:
            self._port: Serial = Serial(device, baudrate, exclusive=True)
        except (OSError, ValueError) as error:
            raise ChannelError(E_OBJ, f"{device}: {_reason(error)}") from error

    def read(self, size: int, seconds: float) -> bytes:
        """Return the available octets, at least one; empty on time-out."""
        port = self._port
        with _as_os_errors():
            if port.timeout != seconds:
                port.timeout = seconds
            data: bytes = port.read(min(max(port.in_waiting, 1), size))
        return data

    def write(self, data: bytes, seconds: float) -> None:
        """Write all octets."""
        with _as_os_errors():
            if self._port.write_timeout != seconds:
                self._port.write_timeout = seconds
            self._port.write(data)

    def drain(self, deadline: float) -> bool:
        """Discard input until the line is silent; return False if that takes too long."""
        while monotonic() < deadline:
            if not self.read(_BLOCK, self._silence):
                return True
        return False

    def discard(self) -> None:
        """Discard the received octets."""
        with _as_os_errors():
            self._port.reset_input_buffer()

    def interrupt(self) -> None:
        """Make another thread's `read` return, unless the line is closed."""
        with self._closing:
            self._port.cancel_read()

    def close(self) -> None:
        """Close the line."""
        with self._closing:
            self._port.close()


class SerialChannel(ConnectedChannel[_Line]):
    """A caller's end of a serial line, opened by the first call. See `Channel`.

    `timeout` [s] applies to a whole call. A call after a failed one, or after octets beyond a
    reply, waits for silence. Without pyserial, calls raise ChannelError (E_OBJ).
    """

    def __init__(
        self, device: str, baudrate: int = BAUDRATE, timeout: float = TIMEOUT
    ) -> None:
        super().__init__(timeout)
        self.device = device
        self.baudrate = baudrate
        self._deadline = 0.0
        self._disturbed = False

    def __str__(self) -> str:
        return self.device

    def open(self) -> None:
        """Open the line, unless it is open. Raises ChannelError."""
        if self._connection is None:
            self._connection = _Line(self.device, self.baudrate)

    def _begin(self, request: bytes, first: int) -> bytes:
        self._deadline = monotonic() + self.timeout
        self.open()
        line = self._open()
        if not self._disturbed:
            line.discard()
        elif not line.drain(self._deadline):
            raise self._time_over()
        self._disturbed = False
        line.write(request, self.timeout)
        if not first:
            return b""
        return self._take(self._hunt(_reply_start(request)), first)

    def close(self) -> None:
        """Close the line after the current call, whose duration `timeout` limits."""
        held = self._lock.acquire(timeout=2 * self.timeout)
        self._drop()
        if held:
            self._lock.release()

    def _error(self, error: OSError) -> ChannelError:
        """Return the error to raise; the next call reopens a lost line."""
        from serial import SerialTimeoutException

        if isinstance(error, SerialTimeoutException):
            return self._time_over()
        self._drop()
        return ChannelError(E_OBJ, f"{self}: {error}")

    def _discard(self) -> None:
        self._rest = b""
        self._disturbed = True

    def _send(self, data: bytes) -> None:
        self._open().write(data, self.timeout)

    def _receive(self, missing: int) -> bytes:
        remaining = self._deadline - monotonic()
        data = self._open().read(_BLOCK, remaining) if remaining > 0 else b""
        if not data:
            raise self._time_over()
        return data

    def _hunt(self, sop: bytes) -> bytes:
        """Skip noise; return what begins with the reply."""
        data = b""
        while (at := data.find(sop)) < 0:
            data = data[-1:] + self._receive(1)
        return data[at:]


class _SerialReader(MessageReader):
    """Reads requests from a line."""

    def __init__(self, line: _Line, server: SerialServer) -> None:
        super().__init__(server.allocator_size)
        self._line = line
        self._server = server

    def head(self, n: int) -> bytes:
        """See `MessageReader`. Skips input that is not the start of a request."""
        octets = super().head(1)
        while octets:
            if not any(start.startswith(octets) for start in self._server.starts):
                octets = octets[1:] or super().head(1)
            elif len(octets) == 1:
                octets += self.more(1)
            else:
                break
        self._data = octets + self._data[self._at :]
        self._at = 0
        return super().head(n) if octets else b""

    def _wait(self) -> bytes:
        while not self._server.closed:
            data = self._line.read(_BLOCK, _POLL_INTERVAL)
            if data:
                return data
        return b""

    def _receive(self, size: int) -> bytes:
        if self._deadline is None:
            self._deadline = monotonic() + self._server.timeout
        remaining = self._deadline - monotonic()
        data = self._line.read(_BLOCK, remaining) if remaining > 0 else b""
        if not data:
            raise ChannelError(
                E_TMOUT, f"a request took longer than {self._server.timeout} s"
            )
        return data


class SerialServer(ConnectedServer):
    """Serves a serial line. See `ConnectedServer`.

    After an error it discards input until the line is silent; there is no reply. For a lost line,
    such as an unplugged adapter, `serve_forever` raises ChannelError.
    """

    def __init__(
        self,
        service: Service,
        device: str,
        baudrate: int = BAUDRATE,
        timeout: float = TIMEOUT,
        allocator_size: int | None = None,
    ) -> None:
        super().__init__(service, timeout, allocator_size)
        self.device = device
        self.closed = False
        self.starts = starts(service)
        self._line = _Line(device, baudrate)

    def serve_forever(self) -> None:
        """Serve requests until another thread or a signal handler calls `close`."""
        try:
            while not self.closed:
                reader = _SerialReader(self._line, self)
                if not serve(self._service, reader, self._send, self.device):
                    self._drain()
        except OSError as error:
            if not self.closed:
                raise ChannelError(E_OBJ, f"{self.device}: {error}") from error
        finally:
            self._line.close()

    def close(self) -> None:
        """Close the line and wait for the thread of `start`."""
        self.closed = True
        self._line.interrupt()
        self._join()

    def _drain(self) -> None:
        while not self.closed:
            if self._line.drain(monotonic() + _POLL_INTERVAL):
                log.info("%s: silent again", self.device)
                return

    def _send(self, reply: bytes) -> None:
        try:
            self._line.write(reply, self.timeout)
        except OSError as error:
            raise ChannelError(E_OBJ, f"{self.device}: {error}") from error
