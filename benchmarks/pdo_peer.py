"""A device behind a socketcand server of its own, which sends PDOs as fast as possible.

`benchmarks/pdo.py` starts it: it prints its port, serves one connection after another, and for each
number in its standard input sends that many frames of TPDO 1. It answers the requests of a proxy's
activation: SDO uploads and NMT commands.
"""

from __future__ import annotations

import socket
import sys
import threading

NODE = 5
TPDO = 0x180 + NODE
PER_WRITE = 64
STATES = {0x01: 0x05, 0x02: 0x04, 0x80: 0x7F}
OBJECTS = {0x1000: bytes(4), 0x1017: (30_000).to_bytes(2, "little")}
SIZES = {4: 0x43, 2: 0x4B}


def frame(identifier: int, data: bytes) -> bytes:
    return f"< frame {identifier:03X} 1.000000 {data.hex().upper()} >".encode()


def answer(text: str) -> bytes:
    """Return the device's answer to a frame."""
    words = text.split()
    identifier, data = int(words[1], 16), bytes(int(w, 16) for w in words[3:])
    if identifier == 0x000 and data[1] in (0, NODE) and data[0] in STATES:
        return frame(0x700 + NODE, bytes((STATES[data[0]],)))
    if identifier == 0x600 + NODE and data[0] == 0x40:
        value = OBJECTS.get(data[1] | data[2] << 8)
        if value is None:
            return frame(0x580 + NODE, b"\x80" + data[1:4] + bytes((0, 0, 2, 6)))
        head = bytes((SIZES[len(value)],)) + data[1:4]
        return frame(0x580 + NODE, head + value.ljust(4, b"\0"))
    return b""


class Peer:
    """The server, and its connection."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._connection: socket.socket | None = None
        self._lock = threading.Lock()
        print(self._server.getsockname()[1], flush=True)

    def serve(self) -> None:
        while True:
            connection, _ = self._server.accept()
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with connection:
                self._talk(connection)
            self._connection = None

    def _talk(self, connection: socket.socket) -> None:
        connection.sendall(b"< hi >")
        waiting = ""
        while data := connection.recv(4096):
            waiting += data.decode()
            while ">" in waiting:
                text, _, waiting = waiting.partition(">")
                words = text.strip("< ")
                if words.startswith(("open", "rawmode")):
                    connection.sendall(b"< ok >")
                    if words == "rawmode":
                        self._connection = connection
                elif words.startswith("send"):
                    with self._lock:
                        connection.sendall(answer(words))

    def send(self, count: int) -> None:
        """Send PDOs; the counter is in the first two octets."""
        connection = self._connection
        assert connection is not None
        for first in range(0, count, PER_WRITE):
            numbers = range(first, min(first + PER_WRITE, count))
            octets = (number.to_bytes(2, "little") for number in numbers)
            with self._lock:
                connection.sendall(
                    b"".join(frame(TPDO, o + b"\1\0\2\0\3\0") for o in octets)
                )


def main() -> None:
    peer = Peer()
    threading.Thread(target=peer.serve, daemon=True).start()
    for line in sys.stdin:
        peer.send(int(line))


if __name__ == "__main__" and sys.argv[1:] == ["serve"]:
    main()
