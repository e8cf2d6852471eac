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
from types import TracebackType
from typing import TYPE_CHECKING

from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc.connection import checked_timeout
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
                E_OBJ, "serial lines need pyserial: pip install 'rtgen[serial]'"
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


class SerialChannel:
    """A caller's end of a serial line, opened by the first call. See `Channel`.

    `timeout` [s] applies to a whole call. Without pyserial, calls raise ChannelError (E_OBJ).
    """

    def __init__(
        self, device: str, baudrate: int = BAUDRATE, timeout: float = TIMEOUT
    ) -> None:
        self.device = device
        self.baudrate = baudrate
        self.timeout = checked_timeout(timeout)
        self._lock = threading.Lock()
        self._line: _Line | None = None
        self._deadline = 0.0
        self._rest = b""
        self._disturbed = False

    def __str__(self) -> str:
        return self.device

    def open(self) -> None:
        """Open the line, unless it is open. Raises ChannelError."""
        if self._line is None:
            self._line = _Line(self.device, self.baudrate)

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`. After a failed call, waits for silence first."""
        if not self._lock.acquire(timeout=self.timeout):
            raise ChannelError(E_TMOUT, f"{self}: in use by another call")
        try:
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
            self._hunt(_reply_start(request))
            return self._take(first)
        except BaseException as error:
            self.reset()
            if isinstance(error, OSError):
                raise self._error(error) from error
            raise

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        try:
            return self._take(n)
        except OSError as error:
            raise self._error(error) from error

    def write(self, data: bytes) -> None:
        """Write data of the current call that follow its reply. Raises ChannelError."""
        try:
            self._open().write(data, self.timeout)
        except OSError as error:
            raise self._error(error) from error

    def end(self) -> None:
        """See `Channel`."""
        if self._rest:
            log.info("%s: %d bytes beyond the reply", self, len(self._rest))
            self._rest = b""
            self._disturbed = True
        self._lock.release()

    def reset(self) -> None:
        """See `Channel`: the next call waits for silence."""
        self._rest = b""
        self._disturbed = True
        if self._lock.locked():
            self._lock.release()

    def close(self) -> None:
        """Close the line after the current call, whose duration `timeout` limits."""
        held = self._lock.acquire(timeout=2 * self.timeout)
        self._drop()
        if held:
            self._lock.release()

    def _open(self) -> _Line:
        if self._line is None:
            raise ChannelError(E_OBJ, f"{self}: no call is under way")
        return self._line

    def _drop(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            line.close()

    def _error(self, error: OSError) -> ChannelError:
        """Return the error to raise; the next call reopens a lost line."""
        from serial import SerialTimeoutException

        if isinstance(error, SerialTimeoutException):
            return self._time_over()
        self._drop()
        return ChannelError(E_OBJ, f"{self}: {error}")

    def _time_over(self) -> ChannelError:
        return ChannelError(E_TMOUT, f"{self}: no answer within {self.timeout} s")

    def _receive(self, size: int) -> bytes:
        left = self._deadline - monotonic()
        data = self._open().read(size, left) if left > 0 else b""
        if not data:
            raise self._time_over()
        return data

    def _hunt(self, sop: bytes) -> None:
        """Skip noise, so that the received data begin with the reply."""
        data = b""
        while (at := data.find(sop)) < 0:
            data = data[-1:] + self._receive(_BLOCK)
        self._rest = data[at:]

    def _take(self, n: int) -> bytes:
        pieces = [self._rest]
        missing = n - len(self._rest)
        while missing > 0:
            pieces.append(self._receive(_BLOCK))
            missing -= len(pieces[-1])
        data = b"".join(pieces)
        self._rest = data[n:]
        return data[:n]


class _SerialReader(MessageReader):
    """Reads requests from a line."""

    def __init__(self, line: _Line, server: SerialServer) -> None:
        super().__init__(server.allocator_size)
        self._line = line
        self._server = server

    def head(self, n: int) -> bytes:
        """See `MessageReader`. Skips input that is not the start of a request."""
        found = super().head(1)
        while found:
            if not any(start.startswith(found) for start in self._server.starts):
                found = found[1:] or super().head(1)
            elif len(found) == 1:
                found += self.more(1)
            else:
                break
        self._data = found + self._data[self._at :]
        self._at = 0
        return super().head(n) if found else b""

    def _wait(self) -> bytes:
        while not self._server.closed:
            data = self._line.read(_BLOCK, _POLL_INTERVAL)
            if data:
                return data
        return b""

    def _receive(self, size: int) -> bytes:
        if self._deadline is None:
            self._deadline = monotonic() + self._server.timeout
        left = self._deadline - monotonic()
        data = self._line.read(_BLOCK, left) if left > 0 else b""
        if not data:
            raise ChannelError(
                E_TMOUT, f"a request took longer than {self._server.timeout} s"
            )
        return data


class SerialServer:
    """Serves a serial line. Parameters are those of `TcpServer`.

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
        self.device = device
        self.timeout = checked_timeout(timeout)
        self.allocator_size = allocator_size
        self.closed = False
        self.starts = starts(service)
        self._service = service
        self._line = _Line(device, baudrate)
        self._thread: threading.Thread | None = None

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

    def start(self) -> None:
        """Serve requests in a new thread."""
        self._thread = threading.Thread(
            target=self.serve_forever, name="OpaqueRPC server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Close the line and wait for the thread of `start`."""
        self.closed = True
        self._line.interrupt()
        if self._thread not in (None, threading.current_thread()):
            self._thread.join()

    def __enter__(self) -> SerialServer:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

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
