"""The door of the live view: passes the octets of clients to the server, each at a limited rate.

The server of `foxglove-sdk` reads what it can get and answers each message, also by a refusal, with
the time of the run. A client that sends more than its rate is read later, so that it has to wait.
"""

from __future__ import annotations

import asyncio
import socket
import threading
from contextlib import suppress
from typing import Final

from rtgen.runtime.requests import Rates

MAX_CLIENTS: Final = 64
"""Maximum number of clients; a further connection is closed."""
_RATE: Final = 100.0
"""Messages of a client that are read in a second."""
_TOTAL: Final = 400.0
"""Messages of all clients that send more, which share it."""
_BURST: Final = 100.0
"""Messages of a client that are read at once after it sent none."""
_WEIGHT: Final = 1 / 10_000
"""The part of a message that an octet counts: 1 MB/s of a client."""
_ARRIVAL: Final = 0.02
"""Time between two new clients, which have their bursts [s]."""
_REQUESTS: Final = 2048
"""Octets of a client that are read at once; a message can have seven."""
_SAMPLES: Final = 1 << 20
"""Octets for a client that are read at once."""
_BULK: Final = 1 << 14
_GATHERING: Final = 0.005
"""Time in which samples for a client are gathered, if there are few [s]."""


class Frames:
    """Counts the frames that a client sends after its handshake (RFC 6455, 5.2)."""

    def __init__(self) -> None:
        self._head = bytearray()
        self._left = 0
        """Octets of the current frame that are still to come."""
        self._open = False

    def count(self, octets: bytes) -> int:
        """Return how many frames begin in the next octets; the handshake is one of them."""
        frames, position = 0, 0
        if not self._open:
            frames = not self._head
            self._head += octets
            end = self._head.find(b"\r\n\r\n")
            if end < 0:
                del self._head[:-3]
                return frames
            octets = bytes(self._head[end + 4 :])
            self._head.clear()
            self._open = True
        while position < len(octets):
            if self._left:
                passed = min(self._left, len(octets) - position)
                self._left -= passed
                position += passed
                continue
            frames += not self._head
            self._head.append(octets[position])
            position += 1
            self._begin()
        return frames

    def _begin(self) -> None:
        """Learn the length of a frame when its head is complete."""
        if len(self._head) < 2:
            return
        length = self._head[1] & 0x7F
        size = 2 + {126: 2, 127: 8}.get(length, 0)
        if len(self._head) < size:
            return
        if size > 2:
            length = int.from_bytes(self._head[2:size], "big")
        self._left = length + (4 if self._head[1] & 0x80 else 0)
        self._head.clear()


class Relay:
    """Listens at an address, and connects clients with a server on loopback.

    Raises OSError if it cannot listen.
    """

    def __init__(self, host: str, port: int) -> None:
        family, _, _, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM
        )[0]
        self._listener = socket.create_server(
            address[:2], family=family, backlog=MAX_CLIENTS
        )
        self.port: int = self._listener.getsockname()[1]
        self._target = ("", 0)
        self._rates = Rates(_RATE, _TOTAL, _BURST)
        self._clients: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        self._closing = asyncio.Event()
        self._thread = threading.Thread(
            target=self._run, name="rtgen live view", daemon=True
        )

    def start(self, host: str, port: int) -> None:
        """Begin to connect clients with the server at this address."""
        self._target = host, port
        self._thread.start()

    def close(self) -> None:
        """Close all connections."""
        if self._thread.ident is None:
            self._loop.close()
        else:
            self._loop.call_soon_threadsafe(self._closing.set)
            self._thread.join()
        self._listener.close()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve())

    async def _serve(self) -> None:
        self._listener.setblocking(False)
        accepting = asyncio.create_task(self._accept())
        await self._closing.wait()
        tasks = [accepting, *self._clients]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _accept(self) -> None:
        while True:
            try:
                client, _ = await self._loop.sock_accept(self._listener)
            except OSError:
                # The client has left already, or the process has no more files.
                await asyncio.sleep(_GATHERING)
                continue
            if len(self._clients) >= MAX_CLIENTS:
                client.close()
            else:
                task = asyncio.create_task(self._connect(client))
                self._clients.add(task)
                task.add_done_callback(self._clients.discard)
            await asyncio.sleep(_ARRIVAL)

    async def _connect(self, client: socket.socket) -> None:
        """Pass octets both ways until one side ends."""
        server = socket.socket()
        with client, server, suppress(OSError):
            for each in (client, server):
                each.setblocking(False)
                each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            await self._loop.sock_connect(server, self._target)
            both = [
                asyncio.create_task(self._pass_requests(client, server)),
                asyncio.create_task(self._pass_samples(server, client)),
            ]
            try:
                await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for task in both:
                    task.cancel()
                await asyncio.gather(*both, return_exceptions=True)

    async def _pass_requests(
        self, client: socket.socket, server: socket.socket
    ) -> None:
        frames = Frames()
        try:
            while octets := await self._loop.sock_recv(client, _REQUESTS):
                messages = frames.count(octets) + len(octets) * _WEIGHT
                await self._loop.sock_sendall(server, octets)
                delay = self._rates.delay(client, messages)
                if delay:
                    await asyncio.sleep(delay)
        finally:
            self._rates.leave(client)

    async def _pass_samples(self, server: socket.socket, client: socket.socket) -> None:
        while octets := await self._loop.sock_recv(server, _SAMPLES):
            await self._loop.sock_sendall(client, octets)
            if len(octets) < _BULK:
                await asyncio.sleep(_GATHERING)
