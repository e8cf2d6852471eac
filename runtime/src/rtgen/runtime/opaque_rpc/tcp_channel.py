"""Caller's channel over TCP."""

from __future__ import annotations

import errno
import os
import socket
from time import monotonic, sleep

from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc.connection import BLOCK, SMALL_BLOCK, Connection
from rtgen.runtime.opaque_rpc.ends import ConnectedChannel
from rtgen.runtime.opaque_rpc.errors import E_BOVR, E_OBJ, ChannelError
from rtgen.runtime.sockets import TIME_OVER

_IDLE = 0.05
"""Seconds since the start of the last call after which a connection is checked before use."""
MIN_PAUSE, MAX_PAUSE = 0.005, 0.1
"""Pauses between attempts to connect, doubled each time [s]."""
_PERMANENT_ERRORS = (errno.EACCES, errno.EPERM, errno.EADDRNOTAVAIL, errno.ENODEV)
"""Errors of connecting that are not retried."""


def is_permanent(error: OSError) -> bool:
    """Return whether another attempt to connect would have the same error."""
    return isinstance(error, socket.gaierror) or error.errno in _PERMANENT_ERRORS


class TcpChannel(ConnectedChannel[Connection]):
    """A caller's connection to a server, opened by the first call and again after an error.

    `timeout` [s] applies to a whole call: connecting, request and reply; and to the wait for
    another call in progress. `bind` is a local address or, on Linux, the name of a network
    interface. Octets beyond a reply close the connection. See `Channel`.
    """

    def __init__(
        self, address: str, port: int, timeout: float = TIMEOUT, bind: str = ""
    ) -> None:
        if not 0 < port < 65536:
            raise ValueError(f"a port is 1 to 65535, not {port}")
        super().__init__(timeout)
        self.address = address
        self.port = port
        self.bind = bind
        self._begun = 0.0
        self._in_pieces = False

    def __str__(self) -> str:
        return f"{self.address}:{self.port}"

    def _begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`. Only a failed connect is retried."""
        now = monotonic()
        idle = now - self._begun
        self._begun = now
        connection = self._connection
        if connection is None or idle > _IDLE or connection.seconds != self.timeout:
            connection = self._ready(idle)
        sent = connection.send(request)
        if sent != len(request):
            connection.send_all(request, self._deadline, sent)
        if not first:
            return b""
        if self._in_pieces:
            connection.acknowledge()
        data = connection.receive(first + SMALL_BLOCK)
        if len(data) == first:
            return data
        return self._take(data or self._ended(), first)

    def close(self) -> None:
        """Close the connection after the current call, or by force after `timeout`.

        A later call reconnects.
        """
        if self._lock.acquire(timeout=self.timeout):
            self.reset()
        elif (connection := self._connection) is not None:
            connection.shut()

    @property
    def _deadline(self) -> float:
        return self._begun + self.timeout

    def _send(self, data: bytes) -> None:
        self._open().send_all(data, self._deadline)

    def _receive(self, missing: int) -> bytes:
        connection = self._open()
        self._in_pieces = True
        connection.acknowledge()
        connection.limit(self._deadline - monotonic())
        piece = connection.receive(min(missing + SMALL_BLOCK, BLOCK))
        return piece or self._ended()

    def _discard(self) -> None:
        self._drop()
        self._rest = b""
        self._in_pieces = False

    def _ended(self) -> bytes:
        raise ChannelError(E_BOVR, f"{self}: the server closed the connection")

    def _error(self, error: OSError) -> ChannelError:
        if isinstance(error, TIME_OVER):
            return self._time_over()
        return ChannelError(E_OBJ, f"{self}: {error.strerror or error}")

    def _ready(self, idle: float) -> Connection:
        """Return the connection with its time limit set, checked if it was idle, or a new one."""
        connection = self._connection
        if connection is None or (idle > _IDLE and not connection.is_quiet()):
            self._discard()
            connection = self._connection = self._connect()
            connection.limit(self._deadline - monotonic())
        else:
            connection.limit(self.timeout)
        return connection

    def _connect(self) -> Connection:
        """Return a new connection, retrying: servers need a moment until they listen again."""
        pause = MIN_PAUSE
        while True:
            try:
                return self._connect_once()
            except OSError as error:
                if is_permanent(error) or monotonic() + pause >= self._deadline:
                    raise
            sleep(pause)
            pause = min(2 * pause, MAX_PAUSE)

    def _connect_once(self) -> Connection:
        try:
            family, kind, protocol, _, address = socket.getaddrinfo(
                self.address, self.port, type=socket.SOCK_STREAM
            )[0]
        except UnicodeError as error:
            raise socket.gaierror(socket.EAI_NONAME, "no name of a host") from error
        peer = socket.socket(family, kind, protocol)
        try:
            if self.bind:
                _bind(peer, self.bind)
            peer.settimeout(max(self._deadline - monotonic(), 1e-6))
            peer.connect(address)
            if peer.getsockname() == peer.getpeername():
                # TCP connects a socket to itself if its port is the one that it connects to.
                raise ConnectionRefusedError(
                    errno.ECONNREFUSED, os.strerror(errno.ECONNREFUSED)
                )
            return Connection(peer, self.timeout)
        except BaseException:
            peer.close()
            raise


def _bind(peer: socket.socket, place: str) -> None:
    """Bind to a local address, or to a network interface by its name."""
    option: int | None = getattr(socket, "SO_BINDTODEVICE", None)
    if option is not None and place in (name for _, name in socket.if_nameindex()):
        peer.setsockopt(socket.SOL_SOCKET, option, place.encode())
    else:
        peer.bind((place, 0))
