"""A TCP port that hands everything over to another one, so that calls cannot stay in a process."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from rtgen.runtime.marshalling.octets import ObjectReference


@contextmanager
def forwarded(reference: ObjectReference) -> Iterator[ObjectReference]:
    """A reference to the same object by another port."""
    (tag, profile), *others = reference.profiles
    # IIOP (CORBA 3.3 part 2, 9.7.2): byte order, version, host, port.
    order = "<" if profile[0] else ">"
    (length,) = struct.unpack_from(f"{order}I", profile, 4)
    host = profile[8 : 7 + length].decode()
    place = 8 + length + length % 2
    (port,) = struct.unpack_from(f"{order}H", profile, place)
    with socket.create_server((host, 0)) as server:
        threading.Thread(target=_accept, args=(server, host, port), daemon=True).start()
        near = struct.pack(f"{order}H", server.getsockname()[1])
        moved = profile[:place] + near + profile[place + 2 :]
        yield ObjectReference(reference.type_id, ((tag, moved), *others))


def _accept(server: socket.socket, host: str, port: int) -> None:
    with suppress(OSError):
        while True:
            near, _ = server.accept()
            far = socket.create_connection((host, port))
            for one, other in ((near, far), (far, near)):
                threading.Thread(target=_copy, args=(one, other), daemon=True).start()


def _copy(source: socket.socket, target: socket.socket) -> None:
    with suppress(OSError):
        while data := source.recv(65536):
            target.sendall(data)
    for end in (source, target):
        with suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
        end.close()
