"""What both ends of a connection have in common over TCP and over a serial line."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from typing import Generic, Protocol, Self, TypeVar

from rtgen.facts.opaque_rpc import MAX_TIMEOUT
from rtgen.runtime.closable import Closable
from rtgen.runtime.opaque_rpc.errors import E_OBJ, E_TMOUT, ChannelError
from rtgen.runtime.opaque_rpc.messages import Service, log


class _Closable(Protocol):
    def close(self) -> None: ...


_C = TypeVar("_C", bound=_Closable)


def checked_timeout(seconds: float) -> float:
    """Return the time-out. Raises ValueError unless it is in (0, `MAX_TIMEOUT`]."""
    if not 0 < seconds <= MAX_TIMEOUT:
        raise ValueError(
            f"a time-out is a positive number of seconds up to {MAX_TIMEOUT:.0f}, not {seconds}"
        )
    return seconds


class ConnectedChannel(ABC, Generic[_C]):
    """A caller's end of a stream of octets, which the first call opens. See `Channel`.

    `timeout` [s] applies to a whole call, and to the wait for another call in progress. Subclasses
    raise OSError, which becomes a ChannelError.
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = checked_timeout(timeout)
        self._lock = threading.Lock()
        self._connection: _C | None = None
        self._rest = b""

    @abstractmethod
    def _begin(self, request: bytes, first: int) -> bytes:
        """See `Channel.begin`; the channel is allocated."""

    @abstractmethod
    def _send(self, data: bytes) -> None:
        """Send all octets, in the time of the call."""

    @abstractmethod
    def _receive(self, missing: int) -> bytes:
        """Return at least one octet, in the time of the call; `missing` are needed."""

    @abstractmethod
    def _discard(self) -> None:
        """Forget the rest of a reply, that which is still under way, too."""

    @abstractmethod
    def _error(self, error: OSError) -> ChannelError:
        """Return the error to raise."""

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`."""
        lock = self._lock
        if not lock.acquire(False) and not lock.acquire(timeout=self.timeout):
            raise ChannelError(E_TMOUT, f"{self}: in use by another call")
        try:
            return self._begin(request, first)
        except BaseException as error:
            self.reset()
            if isinstance(error, OSError):
                raise self._error(error) from error
            raise

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        rest = self._rest
        if len(rest) >= n:
            self._rest = rest[n:]
            return rest[:n]
        try:
            return self._take(rest, n)
        except OSError as error:
            raise self._error(error) from error

    def write(self, data: bytes) -> None:
        """Write data of the current call that follow its reply. Raises ChannelError."""
        try:
            self._send(data)
        except OSError as error:
            raise self._error(error) from error

    def end(self) -> None:
        """See `Channel`. The call succeeds, also if octets follow the reply."""
        if self._rest:
            log.info("%s: %d bytes beyond the reply", self, len(self._rest))
            self._discard()
        self._lock.release()

    def reset(self) -> None:
        """See `Channel`."""
        self._discard()
        if self._lock.locked():
            self._lock.release()

    def _take(self, data: bytes, n: int) -> bytes:
        """Return n octets, of which `data` were received; further ones are stored in `_rest`."""
        if len(data) < n:
            pieces = [data]
            missing = n - len(data)
            while missing > 0:
                pieces.append(self._receive(missing))
                missing -= len(pieces[-1])
            data = b"".join(pieces)
        self._rest = data[n:]
        return data[:n]

    def _open(self) -> _C:
        if self._connection is None:
            raise ChannelError(E_OBJ, f"{self}: no call is under way")
        return self._connection

    def _drop(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()

    def _time_over(self) -> ChannelError:
        return ChannelError(E_TMOUT, f"{self}: no answer within {self.timeout} s")


class ConnectedServer(Closable):
    """Serves streams of octets, in this thread or in one of its own.

    `timeout` [s] applies to the rest of a request after its first octet, and to its reply; between
    requests a client may be silent. `allocator_size` limits the octets of a whole request, in
    addition to the codec's limit of arrays and texts (`PPAllocatorSize`).
    """

    def __init__(
        self, service: Service, timeout: float, allocator_size: int | None
    ) -> None:
        self.timeout = checked_timeout(timeout)
        self.allocator_size = allocator_size
        self._service = service
        self._thread: threading.Thread | None = None

    @abstractmethod
    def serve_forever(self) -> None:
        """Serve until another thread calls `close`."""

    @abstractmethod
    def close(self) -> None:
        """Serve no more; waits for the thread of `start`."""

    def start(self) -> None:
        """Serve in a new thread."""
        self._thread = threading.Thread(
            target=self.serve_forever, name="OpaqueRPC server", daemon=True
        )
        self._thread.start()

    def _join(self) -> None:
        """Wait for the thread of `start`."""
        if self._thread not in (None, threading.current_thread()):
            self._thread.join()

    def __enter__(self) -> Self:
        self.start()
        return self
