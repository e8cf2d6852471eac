"""A server over TCP, for one client at a time."""

from __future__ import annotations

import os
import selectors
import socket
import threading
from time import monotonic
from types import TracebackType

from rtgen.runtime.opaque_rpc.codecs import REQUEST_LIMIT
from rtgen.runtime.opaque_rpc.connection import (
    BLOCK,
    LARGE_BLOCK,
    TIME_OVER,
    TIMEOUT,
    Connection,
    checked_timeout,
)
from rtgen.runtime.opaque_rpc.errors import E_OBJ, E_TMOUT, ChannelError
from rtgen.runtime.opaque_rpc.messages import (
    MessageReader,
    Service,
    log,
    serve,
)


class _SocketReader(MessageReader):
    """Reads requests from a connection."""

    def __init__(self, connection: Connection, timeout: float, limit: int) -> None:
        super().__init__(limit)
        self._connection = connection
        self._timeout = timeout
        self._in_pieces = False

    def _wait(self) -> bytes:
        connection = self._connection
        if connection.seconds != self._timeout:
            connection.limit(self._timeout)
        while True:
            try:
                if self._in_pieces:
                    connection.acknowledge()
                return connection.receive(BLOCK)
            except TIME_OVER:
                continue
            except ConnectionError as error:
                raise ChannelError(
                    E_OBJ, error.strerror or "connection lost"
                ) from error

    def _receive(self, size: int) -> bytes:
        connection = self._connection
        if self._deadline is None:
            self._deadline = monotonic() + self._timeout
        self._in_pieces = True
        try:
            connection.acknowledge()
            connection.limit(self._deadline - monotonic())
            return connection.receive(min(max(size, BLOCK), LARGE_BLOCK))
        except TIME_OVER as error:
            raise ChannelError(
                E_TMOUT, f"a request took longer than {self._timeout} s"
            ) from error
        except OSError as error:
            raise ChannelError(E_OBJ, error.strerror or "connection lost") from error

    def send(self, reply: bytes) -> None:
        """Sends a reply; raises ChannelError."""
        connection = self._connection
        try:
            sent = connection.send(reply)
            if sent != len(reply):
                connection.send_all(reply, monotonic() + self._timeout, sent)
        except TIME_OVER as error:
            raise ChannelError(E_TMOUT, "the client does not read the reply") from error
        except OSError as error:
            raise ChannelError(E_OBJ, error.strerror or "connection lost") from error


class TcpServer:
    """Serves one client at a time; others are refused while it is connected, as by C servers.

    So no request waits unseen in a queue, to be executed when its caller has given up. `port` 0
    takes a free one, see `address`. `timeout` [s] is for the rest of a request once its first byte
    is here, and for its reply; between requests a client may be silent. `allocator_size` limits
    the bytes of a request. An error closes the connection without a reply.
    """

    def __init__(
        self,
        service: Service,
        host: str = "127.0.0.1",
        port: int = 0,
        timeout: float = TIMEOUT,
        allocator_size: int = REQUEST_LIMIT,
    ) -> None:
        self.timeout = checked_timeout(timeout)
        self.allocator_size = allocator_size
        self._service = service
        self._lock = threading.Lock()
        self._closed = False
        self._thread: threading.Thread | None = None
        self._connection: Connection | None = None
        self._listener = _listen(host, port)
        self._wake, self._alarm = socket.socketpair()
        name = self._listener.getsockname()
        self.address: tuple[str, int] = (name[0], name[1])

    def serve_forever(self) -> None:
        """Serves clients until another thread or a signal handler calls `close`."""
        while (peer := self._accept()) is not None:
            connection = Connection(peer, self.timeout)
            with self._lock:
                self._connection = None if self._closed else connection
            if self._connection is not None:
                reader = _SocketReader(connection, self.timeout, self.allocator_size)
                serve(self._service, reader, reader.send)
            with self._lock:
                self._connection = None
                if not self._closed:
                    # Who sees the end of the connection finds a server that listens.
                    self._listener = _listen(*self.address)
            connection.close()

    def start(self) -> None:
        """Serves clients in a thread of its own."""
        self._thread = threading.Thread(
            target=self.serve_forever, name="OpaqueRPC server", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Ends the connection and listens no more; waits for the thread of `start`."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._alarm.close()
                self._listener.close()
            if self._connection is not None:
                self._connection.shut()
        if self._thread not in (None, threading.current_thread()):
            self._thread.join()

    def __enter__(self) -> TcpServer:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _accept(self) -> socket.socket | None:
        """The next client; listens no more then. None when the server is closed."""
        with selectors.DefaultSelector() as selector, self._listener as listener:
            with self._lock:
                if self._closed:
                    self._wake.close()
                    return None
                selector.register(listener, selectors.EVENT_READ)
                selector.register(self._wake, selectors.EVENT_READ)
            while True:
                selector.select()
                with self._lock:
                    if self._closed:
                        self._wake.close()
                        return None
                    try:
                        peer, who = listener.accept()
                    except OSError as error:
                        log.debug("accept: %s", error)
                        continue
                log.debug("client %s", who)
                return peer


def _listen(host: str, port: int) -> socket.socket:
    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listener = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(1)
        listener.setblocking(False)
    except BaseException:
        listener.close()
        raise
    return listener
