"""A TCP port that forwards to another one, so that calls cannot stay in a process."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from rtgen.runtime.marshalling.octets import ObjectReference


@contextmanager
def forwarded(reference: ObjectReference) -> Iterator[ObjectReference]:
    """Yield a reference to the same object by another port."""
    (tag, profile), *others = reference.profiles
    # IIOP (CORBA 3.3 part 2, 9.7.2): byte order, version, host, port.
    order = "<" if profile[0] else ">"
    (length,) = struct.unpack_from(f"{order}I", profile, 4)
    host = profile[8 : 7 + length].decode()
    place = 8 + length + length % 2
    (port,) = struct.unpack_from(f"{order}H", profile, place)
    near = socket.create_server((host, 0))
    forwarder = Forwarder(near, (host, port))
    try:
        number = struct.pack(f"{order}H", near.getsockname()[1])
        moved = profile[:place] + number + profile[place + 2 :]
        yield ObjectReference(reference.type_id, ((tag, moved), *others))
    finally:
        forwarder.close()


class Forwarder:
    """Forwards data of connections, in threads of its own, at first after a delay [s].

    A socket is closed when no thread uses it any more: its number may be reused at once.
    """

    def __init__(
        self, server: socket.socket, address: tuple[str, int], delay: float = 0.0
    ) -> None:
        self._server = server
        self._delay = delay
        self._address = address
        self._ends: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._acceptor = threading.Thread(target=self._accept, daemon=True)
        self._acceptor.start()

    def close(self) -> None:
        """End all connections, and wait for the threads."""
        _shut(self._server)
        self._acceptor.join()
        for end in self._ends:
            _shut(end)
        for thread in self._threads:
            thread.join()
        for end in (self._server, *self._ends):
            end.close()

    def _accept(self) -> None:
        time.sleep(self._delay)
        with suppress(OSError):
            while True:
                near, _ = self._server.accept()
                self._ends.append(near)
                far = socket.create_connection(self._address)
                self._ends.append(far)
                for pair in ((near, far), (far, near)):
                    thread = threading.Thread(target=_copy, args=pair, daemon=True)
                    self._threads.append(thread)
                    thread.start()


def _copy(source: socket.socket, target: socket.socket) -> None:
    with suppress(OSError):
        while data := source.recv(65536):
            target.sendall(data)
    for end in (source, target):
        _shut(end)


def _shut(end: socket.socket) -> None:
    with suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
