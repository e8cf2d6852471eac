"""Server over TCP, for one client at a time."""

from __future__ import annotations

import os
import select
import selectors
import socket
from time import monotonic

from rtgen.facts.opaque_rpc import TIMEOUT
from rtgen.runtime.opaque_rpc.channel import Handlers
from rtgen.runtime.opaque_rpc.connection import BLOCK, SMALL_BLOCK, Connection
from rtgen.runtime.opaque_rpc.ends import ConnectedServer
from rtgen.runtime.opaque_rpc.errors import E_OBJ, E_TMOUT, ChannelError
from rtgen.runtime.opaque_rpc.messages import (
    HEAD,
    MessageReader,
    Send,
    Service,
    find_handler,
    log,
    serve,
)
from rtgen.runtime.requests import await_turn, charge
from rtgen.runtime.sockets import TIME_OVER, await_files

_POLL_INTERVAL = 0.2
"""Period [s] at which a waiting server checks whether it was closed, if nothing wakes it."""
_QUEUE = 8
_HANG_UP: int = getattr(select, "POLLRDHUP", 0)


class _SocketReader(MessageReader):
    """Reads requests from a connection."""

    def __init__(
        self, connection: Connection, timeout: float, limit: int | None
    ) -> None:
        super().__init__(limit)
        self._connection = connection
        self._timeout = timeout
        self._in_pieces = False

    def serve(self, handlers: Handlers, send: Send) -> None:
        """See `MessageReader`; fast path for requests received in one piece."""
        receive, begin = self._connection.receive, self._begin
        more, find = self.more, handlers.get
        while True:
            if self._in_pieces or self._at < len(self._data):
                head = self.head(HEAD)
            else:
                try:
                    head = begin(receive(SMALL_BLOCK), 0, HEAD)
                except OSError as error:
                    _pass_silence(error)
                    continue
            if not head:
                return
            handler = find(head) or find_handler(head, more, handlers)
            begun = await_turn()
            reply = handler(more)
            if reply is not None:
                send(reply)
            charge(begun)

    def _wait(self) -> bytes:
        connection = self._connection
        connection.limit(self._timeout)
        while True:
            try:
                if self._in_pieces:
                    connection.acknowledge()
                return connection.receive(SMALL_BLOCK)
            except OSError as error:
                _pass_silence(error)

    def _receive(self, size: int) -> bytes:
        connection = self._connection
        if self._deadline is None:
            self._deadline = monotonic() + self._timeout
        self._in_pieces = True
        try:
            connection.acknowledge()
            connection.limit(self._deadline - monotonic())
            return connection.receive(min(size + SMALL_BLOCK, BLOCK))
        except TIME_OVER as error:
            raise ChannelError(
                E_TMOUT, f"a request took longer than {self._timeout} s"
            ) from error
        except OSError as error:
            raise _lost(error) from error

    def send(self, reply: bytes) -> None:
        """Send a reply. Raises ChannelError."""
        connection = self._connection
        try:
            sent = connection.send(reply)
            if sent != len(reply):
                connection.send_all(reply, monotonic() + self._timeout, sent)
                connection.limit(self._timeout)
        except TIME_OVER as error:
            raise ChannelError(E_TMOUT, "the client does not read the reply") from error
        except OSError as error:
            raise _lost(error) from error


def _lost(error: OSError) -> ChannelError:
    return ChannelError(E_OBJ, error.strerror or "connection lost")


def _pass_silence(error: OSError) -> None:
    """Ignore silence between requests; any other error ends the connection."""
    if not isinstance(error, TIME_OVER):
        raise _lost(error) from error


class _Listener:
    """Listener that serves one client at a time; the rest wait in the accept queue.

    A client that has waited for longer than `patience` [s] and has disconnected is not served.
    """

    def __init__(self, host: str, port: int, patience: float) -> None:
        self._listener = _listen(host, port)
        name = self._listener.getsockname()
        self.address: tuple[str, int] = (name[0], name[1])
        self.closed = False
        self._patience = patience
        self._since = monotonic()

    def next(self) -> socket.socket | None:
        """Return the next client; None when the listener is closed."""
        waited = monotonic() - self._since > self._patience
        while not self.closed:
            try:
                peer, who = self._listener.accept()
            except BlockingIOError:
                waited = False
                self._wait()
            except OSError as error:
                log.debug("accept: %s", error)
                await_files(error)
            else:
                if not (waited and _has_left(peer)):
                    log.debug("client %s", who)
                    self._since = monotonic()
                    return peer
                log.info("client %s has left", who)
                peer.close()
        return None

    def close(self) -> None:
        """Stop accepting clients; `next` in another thread returns."""
        self.closed = True
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError as error:
            log.debug("shutdown: %s", error)

    def release(self) -> None:
        """Free the socket, after `close`."""
        self._listener.close()

    def _wait(self) -> None:
        try:
            selector = selectors.DefaultSelector()
        except OSError as error:
            await_files(error)
            return
        with selector:
            try:
                selector.register(self._listener, selectors.EVENT_READ)
            except ValueError:
                if not self.closed:
                    raise
                return  # another thread has released it
            while not selector.select(_POLL_INTERVAL) and not self.closed:
                continue


def _has_left(peer: socket.socket) -> bool:
    """Return whether a client has given up, so that its request must not be executed."""
    if not _HANG_UP:
        return False
    poll = select.poll()
    poll.register(peer, _HANG_UP)
    return bool(poll.poll(0))


class TcpServer(ConnectedServer):
    """Serves one client at a time; others wait until it disconnects.

    A request whose caller has given up is not executed (Linux). `port` 0 selects a free one, see
    `address`. An error closes the connection without a reply. See `ConnectedServer`.
    """

    def __init__(
        self,
        service: Service,
        host: str = "127.0.0.1",
        port: int = 0,
        timeout: float = TIMEOUT,
        allocator_size: int | None = None,
    ) -> None:
        super().__init__(service, timeout, allocator_size)
        self._door = _Listener(host, port, self.timeout)
        self.address = self._door.address
        self._connection: Connection | None = None

    def serve_forever(self) -> None:
        """Serve clients until another thread calls `close`."""
        while (peer := self._door.next()) is not None:
            self._connection = connection = Connection(peer, self.timeout)
            try:
                if not self._door.closed:
                    self._serve(connection, _name_of(peer))
            finally:
                connection.close()

    def close(self) -> None:
        """Close the connection and stop listening; waits for the thread of `start`."""
        self._door.close()
        connection = self._connection
        if connection is not None:
            connection.shut()
        self._join()
        self._door.release()

    def _serve(self, connection: Connection, peer: str) -> None:
        reader = _SocketReader(connection, self.timeout, self.allocator_size)
        serve(self._service, reader, reader.send, peer)


def _name_of(peer: socket.socket) -> str:
    try:
        host, port = peer.getpeername()[:2]
    except OSError:
        return "a client that has left"
    return f"{host}:{port}"


def _listen(host: str, port: int) -> socket.socket:
    family, kind, protocol, _, address = socket.getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )[0]
    listener = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(_QUEUE)
        listener.setblocking(False)
    except BaseException:
        listener.close()
        raise
    return listener
