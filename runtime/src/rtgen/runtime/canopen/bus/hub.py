"""A CAN bus for processes of one machine; clients speak `socketcand` or `slcan`.

A single thread with asyncio. Each channel name is a separate bus.
"""

from __future__ import annotations

import asyncio
import socket
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, cast

import msgspec

from rtgen.runtime.canopen.bus.arbitration import Arbiter, transmission_time
from rtgen.runtime.canopen.bus.hub_faults import Fault, Faults, times_off
from rtgen.runtime.canopen.bus.hub_text import (
    Elements,
    Malformed,
    error_text,
    frame_text,
    is_channel,
    sent_frame,
    slcan_text,
)
from rtgen.runtime.canopen.wire.frames import SECOND, Frame
from rtgen.runtime.timing.steady import steady_utc

QUEUE: Final = 1024
"""Maximum number of frames queued for or from a client."""
MAX_CLIENTS: Final = 500
MAX_CHANNELS: Final = 64
HOLD: Final = 0.05
"""Seconds for which the first frames are delayed, so that the preceding answer arrives alone."""
_MAX_DELAYED: Final = 16384
"""Number of frames queued during the delay, since the client cannot read them yet."""
_BUS_OFF, _RESTARTED = 0x40, 0x100
"""Error classes of SocketCAN."""
_OCTETS: Final = 64
"""Approximate size of a frame in a socket's buffer."""
_MIN_BUFFER: Final = 16384

Report = Callable[[str], None]


class HubSettings(msgspec.Struct, frozen=True, gc=False):
    """`bit_rate` in bit/s (0: frames take no time); `queue`: maximum frames per client."""

    bit_rate: int = 0
    queue: int = QUEUE
    faults: tuple[Fault, ...] = ()
    seed: int = 0


class Carried:
    """A transmitted frame, with its cached text in each protocol."""

    __slots__ = ("_line", "_text", "frame", "time")

    def __init__(self, frame: Frame, time: int) -> None:
        self.frame = frame
        self.time = time
        self._text: bytes | None = None
        self._line: bytes | None = None

    @property
    def text(self) -> bytes:
        """The frame in the protocol of socketcand."""
        if self._text is None:
            self._text = frame_text(self.frame, self.time)
        return self._text

    @property
    def line(self) -> bytes:
        """The frame in the protocol of slcan."""
        if self._line is None:
            self._line = slcan_text(self.frame)
        return self._line


class Port(ABC):
    """A client of a bus; `name` identifies it in messages."""

    def __init__(self, name: str, settings: HubSettings, report_event: Report) -> None:
        self.name = name
        self.bus: HubBus | None = None
        self.refused = 0
        """Number of malformed frames received from the client."""
        self._report_event = report_event
        self._limit = settings.queue
        self._queue_limit = settings.queue
        self._queue: deque[bytes] = deque()

    def give(self, carried: Carried) -> None:
        """Queue a frame for the client; disconnect the client if its queue is full."""
        text = self.text_of(carried)
        if text is not None:
            self._append(text)

    @abstractmethod
    def give_error(self, kind: int) -> None:
        """Queue an error frame of this class, if the protocol has error frames."""

    @abstractmethod
    def text_of(self, carried: Carried) -> bytes | None:
        """Return the text of a frame for the client, None to omit it."""

    @abstractmethod
    def flush(self) -> None:
        """Write queued text, unless the client has not read earlier text yet."""

    @abstractmethod
    def cut_off(self, why: str) -> None:
        """Disconnect the client."""

    @abstractmethod
    def read_on(self) -> None:
        """Resume reading from the client, because the bus has room again."""

    def _append(self, text: bytes) -> None:
        self._queue.append(text)
        if len(self._queue) > self._queue_limit:
            self.flush()
            if len(self._queue) > self._queue_limit:
                self._queue.clear()
                self.cut_off("it does not read")

    def _refuse(self, what: object) -> None:
        self.refused += 1
        if self.bus is not None:
            self.bus.refused += 1
        if self.refused == 1:
            self._report_event(f"{self.name}: refused, no frame: {what}")


class HubBus:
    """A bus: arbitration among queued frames, timing and faults."""

    def __init__(self, channel: str, settings: HubSettings) -> None:
        self.channel = channel
        self.carried = 0
        self.lost = 0
        """Number of frames that faults removed."""
        self.refused = 0
        self.off = False
        self._loop = asyncio.get_running_loop()
        self._settings = settings
        self._faults = (
            Faults(settings.faults, settings.seed) if settings.faults else None
        )
        self._ports: tuple[Port, ...] = ()
        self._stopped: set[Port] = set()
        """Clients whose queues are full."""
        self._arbiter: Arbiter[Port] = Arbiter()
        self._due: asyncio.Handle | None = None
        # With a bit rate, in monotonic ns: when the bus becomes free, and since when frames wait.
        self._free_at = 0
        self._waiting_since = 0
        self._now: int | None = None
        self._ending: deque[tuple[int, Port, Frame]] = deque()

    def join(self, port: Port) -> None:
        """Attach a client."""
        if port not in self._ports:
            self._ports += (port,)

    def leave(self, port: Port) -> None:
        """Detach a client; its queued frames are still sent."""
        self._ports = tuple(other for other in self._ports if other is not port)

    @property
    def is_idle(self) -> bool:
        """Whether no client is attached, and no frame waits."""
        return not (self._ports or self._arbiter or self._ending)

    def has_room(self, port: Port) -> bool:
        """Return whether a client may queue a frame; if not, `read_on` is called later."""
        return self._noted_room(port, self._arbiter.waiting(port))

    def put(self, port: Port, frame: Frame) -> bool:
        """Queue a frame from a client; return whether it may queue another, as `has_room`."""
        if self.off:
            self.lost += 1
            return True
        if self._settings.bit_rate:
            now = self._instant()
            self._start_frames(now - 1)
            if not self._arbiter:
                self._waiting_since = now
        waiting = self._arbiter.put(port, frame)
        if self._due is None:
            # Deferred, so that frames sent by others at the same time compete.
            self._due = self._loop.call_soon(self._run)
        return self._noted_room(port, waiting)

    def _noted_room(self, port: Port, waiting: int) -> bool:
        if waiting < self._settings.queue:
            return True
        self._stopped.add(port)
        return False

    def turn(self, off: bool) -> None:
        """Enter or leave bus-off."""
        self.off = off
        if off:
            self.lost += self._arbiter.clear() + len(self._ending)
            self._ending.clear()
        for port in self._ports:
            port.give_error(_BUS_OFF if off else _RESTARTED)
            port.flush()

    def _instant(self) -> int:
        """Return the time, constant within one iteration of the event loop."""
        if self._now is None:
            self._now = time.monotonic_ns()
            self._loop.call_soon(self._next_instant)
        return self._now

    def _next_instant(self) -> None:
        self._now = None

    def _run(self) -> None:
        self._due = None
        if self._settings.bit_rate:
            self._end_frames()
        else:
            for _ in range(len(self._arbiter)):
                self._carry(*self._arbiter.take())
        for port in self._ports:
            port.flush()
        if self._stopped:
            stopped, self._stopped = self._stopped, set()
            for port in stopped:
                port.read_on()

    def _start_frames(self, now: int) -> None:
        """Start transmission of frames, each when the previous one has ended."""
        while self._arbiter:
            start = max(self._free_at, self._waiting_since)
            if start > now:
                return
            port, frame = self._arbiter.take()
            self._free_at = start + transmission_time(frame, self._settings.bit_rate)
            self._ending.append((self._free_at, port, frame))

    def _end_frames(self) -> None:
        now = time.monotonic_ns()
        self._start_frames(now)
        while self._ending and self._ending[0][0] <= now:
            _, port, frame = self._ending.popleft()
            self._carry(port, frame)
            self._start_frames(now)
        if self._ending:
            self._due = self._loop.call_at(self._ending[0][0] / SECOND, self._run)

    def _carry(self, sender: Port, frame: Frame) -> None:
        self.carried += 1
        if self._faults is not None:
            delay = self._faults.delay(frame)
            if delay is None:
                self.lost += 1
                return
            if delay:
                self._loop.call_later(delay, self._give_late, sender, frame)
                return
        self._give(sender, frame)

    def _give_late(self, sender: Port, frame: Frame) -> None:
        if self.off:
            self.lost += 1
            return
        self._give(sender, frame)
        for port in self._ports:
            port.flush()

    def _give(self, sender: Port, frame: Frame) -> None:
        carried = Carried(frame, steady_utc())
        for port in self._ports:
            if port is not sender:
                port.give(carried)


class SocketcandPort(Port, asyncio.Protocol):
    """A client that speaks the protocol of socketcand; it receives frames in raw mode only."""

    def __init__(self, hub: Hub) -> None:
        super().__init__("a client", hub.settings, hub.report_event)
        self._hub = hub
        self._elements = Elements()
        self._raw = False
        self._held = False
        self._stuck = False
        self._paused = False
        self._unread = 0
        """Number of answers that the client has not read since it stopped reading."""
        self._ended = False
        self._transport: asyncio.Transport | None = None

    # Called by asyncio

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # No isinstance check: transports of uvloop do not derive from asyncio's.
        transport = cast(asyncio.Transport, transport)
        self._transport = transport
        peer = transport.get_extra_info("peername")
        self.name = f"{peer[0]}:{peer[1]}" if peer else "a client"
        end = transport.get_extra_info("socket")
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if self._limit < QUEUE:
            # Otherwise the kernel's buffer would hold far more frames than the queue.
            size = max(_MIN_BUFFER, self._limit * _OCTETS)
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, size)
        transport.set_write_buffer_limits(high=0)
        if self._hub.admit(self):
            transport.write(b"< hi >")
        else:
            self.cut_off(f"there are {MAX_CLIENTS} clients already")

    def data_received(self, data: bytes) -> None:
        self._elements.feed(data)
        self.read_on()

    def pause_writing(self) -> None:
        self._stuck = True

    def resume_writing(self) -> None:
        self._stuck = False
        self._unread = 0
        self.flush()

    def connection_lost(self, exc: Exception | None) -> None:
        self._ended = True
        self._hub.forget(self)
        if self.bus is not None:
            self.bus.leave(self)
        if self.refused > 1:
            self._report_event(f"{self.name}: {self.refused} refused in all")

    # Called by the bus

    def text_of(self, carried: Carried) -> bytes | None:
        # The protocol has no remote frames.
        return None if carried.frame.remote else carried.text

    def give_error(self, kind: int) -> None:
        if self._raw:
            self._append(error_text(kind, steady_utc()))

    def flush(self) -> None:
        if self._queue and not self._stuck and not self._held and not self._ended:
            assert self._transport is not None
            data = b"".join(self._queue)
            self._queue.clear()
            self._transport.write(data)

    def cut_off(self, why: str) -> None:
        if not self._ended and self._transport is not None:
            self._ended = True
            self._elements = Elements()
            self._report_event(f"{self.name}: cut off, {why}")
            if self.bus is not None:
                self.bus.leave(self)
            self._transport.abort()

    def read_on(self) -> None:
        assert self._transport is not None
        bus = self.bus
        room = bus is None or bus.has_room(self)
        while room:
            if bus is not None and (frame := self._elements.take_sent()) is not None:
                room = bus.put(self, frame)
                continue
            try:
                words = self._elements.take()
                if words is None:
                    if self._paused:
                        self._paused = False
                        self._transport.resume_reading()
                    return
                if bus is None or not words.startswith("send "):
                    self._obey(words)
                    bus = self.bus
                else:
                    room = bus.put(self, sent_frame(words))
            except Malformed as error:
                self._refuse(error)
        self._paused = True
        self._transport.pause_reading()

    def _obey(self, words: str) -> None:
        command, _, rest = words.partition(" ")
        if command == "open" and self.bus is None:
            self.bus = self._hub.bus(rest)
            if self.bus is None:
                self._answer(b"< error could not open bus >")
                self.cut_off(f"no channel for it: {rest[:60]!r}")
                return
            self.name += f" ({rest})"
            self._answer(b"< ok >")
        elif words == "rawmode" and self.bus is not None:
            self._answer(b"< ok >")
            if not self._raw:
                self._raw = self._held = True
                self._queue_limit = max(self._limit, _MAX_DELAYED)
                self.bus.join(self)
                if self.bus.off:
                    self.give_error(_BUS_OFF)
                self._hub.loop.call_later(HOLD, self._release)
        elif words == "echo":
            self._answer(b"< echo >")
        else:
            self._refuse(words)
            if not self._raw:
                # In raw mode, clients would parse the answer as an error frame.
                self._answer(b"< error unknown command >")

    def _release(self) -> None:
        self._held = False
        self.flush()
        self._queue_limit = self._limit

    def _answer(self, text: bytes) -> None:
        if self._stuck:
            self._unread += 1
            if self._unread > self._limit:
                self.cut_off("it does not read")
        if not self._ended:
            assert self._transport is not None
            self._transport.write(text)


class Hub:
    """Buses by name, and their clients. Must be created and used in a running event loop."""

    def __init__(self, settings: HubSettings, report_event: Report) -> None:
        self.settings = settings
        self.report_event = report_event
        self.loop = asyncio.get_running_loop()
        self.buses: dict[str, HubBus] = {}
        self._forgotten = self._carried = self._lost = self._refused = 0
        """The number of forgotten buses, and the sums of their statistics."""
        self._clients: set[SocketcandPort] = set()
        self._server: asyncio.Server | None = None
        self._off = False
        for off, back in times_off(settings.faults):
            self.loop.call_later(off, self._turn, True)
            self.loop.call_later(back, self._turn, False)

    async def listen(self, host: str, port: int) -> tuple[str, int]:
        """Start listening; return the address (port 0 picks a free port). Raises OSError."""
        addresses = await self.loop.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        family, _, _, _, address = addresses[0]
        self._server = await self.loop.create_server(
            lambda: SocketcandPort(self), str(address[0]), port, family=family
        )
        name = self._server.sockets[0].getsockname()
        return name[0], name[1]

    def bus(self, channel: str) -> HubBus | None:
        """Return the bus of a channel name; None for an invalid name, or too many buses in use.

        Buses that nobody uses are forgotten if there are too many, the oldest first.
        """
        bus = self.buses.get(channel)
        if bus is None and is_channel(channel):
            if len(self.buses) >= MAX_CHANNELS:
                self._forget_unused()
            if len(self.buses) < MAX_CHANNELS:
                bus = self.buses[channel] = HubBus(channel, self.settings)
                bus.off = self._off
        return bus

    def _forget_unused(self) -> None:
        used = {client.bus for client in self._clients}
        for name, bus in self.buses.items():
            if bus.is_idle and bus not in used:
                self._forgotten += 1
                self._carried += bus.carried
                self._lost += bus.lost
                self._refused += bus.refused
                del self.buses[name]
                return

    def admit(self, client: SocketcandPort) -> bool:
        """Register a client, unless there are too many."""
        if len(self._clients) >= MAX_CLIENTS:
            return False
        self._clients.add(client)
        return True

    def forget(self, client: SocketcandPort) -> None:
        """Remove a client."""
        self._clients.discard(client)

    async def close(self) -> None:
        """Close all connections."""
        if self._server is not None:
            self._server.close()
        for client in tuple(self._clients):
            if client._transport is not None:
                client._transport.abort()
        if self._server is not None:
            await self._server.wait_closed()

    def report(self) -> Sequence[str]:
        """Return statistics of each bus, as text, and of those that are forgotten."""
        rows = [
            (bus.channel, bus.carried, bus.lost, bus.refused)
            for bus in self.buses.values()
        ]
        if self._forgotten:
            name = f"{self._forgotten} unused channels"
            rows.append((name, self._carried, self._lost, self._refused))
        return [
            f"{name}: {carried} carried, {lost} lost by faults, {refused} refused"
            for name, carried, lost, refused in rows
        ]

    def _turn(self, off: bool) -> None:
        self._off = off
        self.report_event("bus-off" if off else "the buses are back")
        for bus in self.buses.values():
            bus.turn(off)
