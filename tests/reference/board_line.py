"""A line between two processes that a test can cut: over TCP, or between two pseudo terminals."""

from __future__ import annotations

import os
import selectors
import socket
import threading
import tty
from contextlib import suppress
from types import TracebackType


class TcpLine:
    """Forwards connections to a port; while it is cut, new ones are refused."""

    def __init__(self, board: int) -> None:
        self._board = board
        self._open: list[socket.socket] = []
        self._forwarding: list[threading.Thread] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._accepting = self._started(self._listener)

    def __enter__(self) -> TcpLine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.cut()

    def cut(self) -> None:
        """Close the open connections, and refuse new ones."""
        _shut(self._listener)
        # A connection that is being accepted is cut as well.
        self._accepting.join()
        for end in self._open:
            _shut(end)
        for thread in self._forwarding:
            thread.join()
        for end in (self._listener, *self._open):
            end.close()
        self._open.clear()
        self._forwarding.clear()

    def mend(self) -> None:
        """Accept connections again."""
        self._listener = socket.create_server(("127.0.0.1", self.port))
        self._accepting = self._started(self._listener)

    def _started(self, listener: socket.socket) -> threading.Thread:
        thread = threading.Thread(target=self._accept, args=(listener,), daemon=True)
        thread.start()
        return thread

    def _accept(self, listener: socket.socket) -> None:
        while True:
            try:
                near = listener.accept()[0]
            except OSError:
                return
            try:
                far = socket.create_connection(("127.0.0.1", self._board))
            except OSError:
                near.close()
                continue
            self._open += [near, far]
            for source, target in ((near, far), (far, near)):
                for end in (source, target):
                    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                thread = threading.Thread(
                    target=self._forward, args=(source, target), daemon=True
                )
                thread.start()
                self._forwarding.append(thread)

    def _forward(self, source: socket.socket, target: socket.socket) -> None:
        try:
            while data := source.recv(65536):
                target.sendall(data)
            target.shutdown(socket.SHUT_WR)
        except OSError:
            return


def _shut(end: socket.socket) -> None:
    # A connection that the other process has ended, or that is closed, needs no end.
    with suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)


class SerialLine:
    """Two pseudo terminals, `near` and `far`; while the line is cut, written data are lost."""

    def __init__(self) -> None:
        self._masters: list[int] = []
        self._slaves: list[int] = []
        for _ in range(2):
            master, slave = os.openpty()
            tty.setraw(slave)
            self._masters.append(master)
            self._slaves.append(slave)
        self.near, self.far = (os.ttyname(slave) for slave in self._slaves)
        self._whole = True
        self._wake, self._alarm = os.pipe()
        self._thread = threading.Thread(target=self._forward, daemon=True)
        self._thread.start()

    def __enter__(self) -> SerialLine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._alarm)
        self._thread.join()
        for end in (*self._masters, *self._slaves, self._wake):
            os.close(end)

    def cut(self) -> None:
        """Drop data written from now on."""
        self._whole = False

    def mend(self) -> None:
        """Forward data written from now on."""
        self._whole = True

    def _forward(self) -> None:
        others = dict(zip(self._masters, reversed(self._masters), strict=True))
        with selectors.DefaultSelector() as selector:
            for end in (self._wake, *self._masters):
                selector.register(end, selectors.EVENT_READ)
            while True:
                for key, _ in selector.select():
                    if key.fd == self._wake:
                        return
                    data = os.read(key.fd, 4096)
                    if self._whole:
                        os.write(others[key.fd], data)
