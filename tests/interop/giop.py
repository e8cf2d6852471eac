"""The part of GIOP 1.2 over TCP that calls need (CORBA 3.3 part 2, 9.4 and 9.7)."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
from collections.abc import Callable, Iterator

from rtgen.runtime.marshalling.octets import ObjectReference
from rtgen.runtime.services.calls import Reply, ReplyStatus

REQUEST, REPLY = 0, 1
Handle = Callable[[str, bytes, bool], Reply | None]


def _padded(octets: bytes, size: int) -> bytes:
    return octets + bytes(-len(octets) % size)


def _counted(octets: bytes) -> bytes:
    return struct.pack("<I", len(octets)) + octets


def _message(
    kind: int, header: bytes, body: bytes, little_endian: bool = True
) -> bytes:
    content = _padded(bytes(12) + header, 8)[12:] + body if body else header
    order = "<" if little_endian else ">"
    return struct.pack(
        f"{order}4sBBBBI", b"GIOP", 1, 2, little_endian, kind, len(content)
    ) + (content)


def _read(stream: socket.socket) -> tuple[int, bytes, str]:
    """Return kind, complete message, byte order."""
    head = _exactly(stream, 12)
    order = "<" if head[6] & 1 else ">"
    return (
        head[7],
        head + _exactly(stream, struct.unpack(f"{order}I", head[8:])[0]),
        order,
    )


def _exactly(stream: socket.socket, size: int) -> bytes:
    octets = b""
    while len(octets) < size:
        part = stream.recv(size - len(octets))
        if not part:
            raise ConnectionError("closed")
        octets += part
    return octets


def address(reference: ObjectReference) -> tuple[str, int, bytes]:
    """Return host, port and object key of a reference (IIOP profile)."""
    profile = dict(reference.profiles)[0]
    order = "<" if profile[0] else ">"
    (length,) = struct.unpack_from(f"{order}I", profile, 4)
    offset = 8 + length
    host = profile[8 : offset - 1].decode()
    offset += -offset % 2
    (port,) = struct.unpack_from(f"{order}H", profile, offset)
    offset += 2 + -(offset + 2) % 4
    (length,) = struct.unpack_from(f"{order}I", profile, offset)
    return host, port, profile[offset + 4 : offset + 4 + length]


def reference(type_id: str, host: str, port: int, key: bytes) -> ObjectReference:
    """Return a reference to an object at an address."""
    name = _padded(b"\1\1\2\0" + _counted(host.encode() + b"\0"), 2)
    place = _padded(name + struct.pack("<H", port), 4) + _counted(key)
    return ObjectReference(type_id, ((0, _padded(place, 4) + bytes(4)),))


def sender(place: ObjectReference) -> Handle:
    """Return a function that sends calls to the object of a reference."""
    host, port, key = address(place)
    stream = socket.create_connection((host, port), timeout=20)
    numbers = iter(range(1, 1000))

    def send(operation: str, body: bytes, oneway: bool) -> Reply | None:
        number = next(numbers)
        header = struct.pack("<IB3xH2x", number, 0 if oneway else 3, 0)
        header = _padded(header + _counted(key), 4)
        header = _padded(header + _counted(operation.encode() + b"\0"), 4) + bytes(4)
        stream.sendall(_message(REQUEST, header, body))
        if oneway:
            return None
        kind, message, order = _read(stream)
        answered, status, contexts = struct.unpack_from(f"{order}III", message, 12)
        assert (kind, answered, contexts) == (REPLY, number, 0)
        return Reply(ReplyStatus(status), message[24:], order == "<")

    return send


@contextlib.contextmanager
def listening(handlers: dict[bytes, Handle]) -> Iterator[int]:
    """Serve objects by key on a port of this machine, which is yielded."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=_accept, args=(server, handlers), daemon=True).start()
        yield server.getsockname()[1]


def _accept(server: socket.socket, handlers: dict[bytes, Handle]) -> None:
    with contextlib.suppress(OSError):
        while True:
            stream, _ = server.accept()
            threading.Thread(
                target=_serve, args=(stream, handlers), daemon=True
            ).start()


def _serve(stream: socket.socket, handlers: dict[bytes, Handle]) -> None:
    with stream, contextlib.suppress(OSError):
        while True:
            kind, message, order = _read(stream)
            if kind != REQUEST:
                return
            number, flags, _, size = struct.unpack_from(f"{order}IB3xHxxI", message, 12)
            key = message[28 : 28 + size]
            offset = 28 + size + -size % 4
            (size,) = struct.unpack_from(f"{order}I", message, offset)
            operation = message[offset + 4 : offset + 3 + size].decode()
            offset += 4 + size + -size % 4
            (contexts,) = struct.unpack_from(f"{order}I", message, offset)
            offset += 4
            for _ in range(contexts):
                (size,) = struct.unpack_from(f"{order}I", message, offset + 4)
                offset += 8 + size + -size % 4
            body = message[offset + -offset % 8 :]
            if operation == "_is_a":
                reply: Reply | None = Reply(ReplyStatus.NO_EXCEPTION, b"\1")
            else:
                reply = handlers[key](operation, body, order == "<")
            if flags & 1 and reply is not None:
                order = "<" if reply.little_endian else ">"
                header = struct.pack(f"{order}III", number, reply.status, 0)
                stream.sendall(_message(REPLY, header, reply.body, reply.little_endian))
