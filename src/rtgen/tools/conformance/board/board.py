"""The board under test: calls of its functions, and raw octets."""

from __future__ import annotations

import socket
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from time import monotonic, sleep
from typing import ClassVar

from rtgen.runtime.opaque_rpc import (
    REPLY_LIMIT,
    ArgumentError,
    ChannelError,
    ProtocolError,
    RpcError,
    SerialChannel,
    TcpChannel,
)
from rtgen.runtime.opaque_rpc.errors import E_TMOUT
from rtgen.runtime.opaque_rpc.tcp_channel import MAX_PAUSE, MIN_PAUSE, is_permanent
from rtgen.runtime.sockets import TIME_OVER
from rtgen.tools.conformance.check import SkipError
from rtgen.tools.rpc.codecs import Function, Service
from rtgen.tools.rpc.values import Json

MAX_ID = 0x7FFF
_PIECE = 4096
_PAUSE = 0.02
"""Seconds between the segments of a request, so that they are received separately."""


class ConnectError(Exception):
    """The board did not accept a connection."""


@dataclass(frozen=True, slots=True)
class Answer:
    """The response to some octets; `closed`: the board closed the connection."""

    data: bytes
    closed: bool

    def __str__(self) -> str:
        what = f"the answer {self.data[:16].hex(' ')}" if self.data else "no answer"
        return f"{what}, and the connection {'closed' if self.closed else 'open'}"


@dataclass(slots=True)
class BoardUnderTest:
    """A board that serves a signature.

    `address` is that of a TCP port, None for a `serial` device. `answer` is the time-out of a
    response in seconds, `quiet` the time after which no more octets are expected, `stall` the time
    after which the board disconnects a silent client; None: no limit is stated. Methods raise
    RpcError if the board does not respond as required.
    """

    faults: ClassVar[tuple[type[Exception], ...]] = (RpcError, ConnectError)

    service: Service
    functions: Mapping[str, Function]
    address: tuple[str, int] | None
    serial: str | None
    baud: int
    answer: float
    quiet: float = 0.25
    stall: float | None = None

    def explained(self, fault: Exception) -> str:
        """See `Subject`."""
        return str(fault)

    def channel(self) -> TcpChannel | SerialChannel:
        """Return a new channel, which the caller closes."""
        if self.address is None:
            assert self.serial is not None
            return SerialChannel(self.serial, self.baud, self.answer)
        return TcpChannel(*self.address, timeout=self.answer)

    def problem(self, function: Function, arguments: Json, what: str) -> str | None:
        """Call a function; return the problem, or None after a valid reply."""
        try:
            values = function.arguments_from_json(arguments)
        except (ArgumentError, ValueError) as error:
            return f"{function.name}, {what}: {error}"
        channel = self.channel()
        try:
            function.call(channel, values)
            served = not function.oneway or self.serves(channel)
        except RpcError as error:
            return f"{function.name}, {what}: {error}"
        finally:
            channel.close()
        if not served and self.address is not None:
            # The next connection is served after this one: calls do not fill the board's queue.
            self.raw([self.unknown_request], count=1)
        return None

    def serves(self, channel: TcpChannel | SerialChannel) -> bool:
        """Check by a call whether the board still reads requests after a oneway call.

        Returns False if the signature has no function for it.
        """
        for function in self.functions.values():
            if not function.oneway and not function.layout.arguments:
                function.call(channel, ())
                return True
        return False

    @property
    def unknown_request(self) -> bytes:
        """A request of a function that is not in the signature."""
        codec = self.service.codec
        return codec.request_head(MAX_ID - 1) + codec.awaiting_reply

    def raw(
        self, segments: Sequence[bytes], count: int = 0, within: float | None = None
    ) -> Answer:
        """Return the response to octets, up to `count` ones, or until the board closes.

        Without `count`, until the board is quiet. The time-out is `within` seconds, by default
        that of any response.

        Raises SkipError for a serial line, which has no connection to close.
        """
        if self.address is None:
            raise SkipError("a serial line has no connection that could be closed")
        octets = b""
        with self._connected(self.address) as line:
            try:
                for number, segment in enumerate(segments):
                    if number:
                        sleep(_PAUSE)
                    line.sendall(segment)
                end = monotonic() + (self.answer if within is None else within)
                while not count or len(octets) < count:
                    remaining = end - monotonic()
                    if octets and not count:
                        remaining = min(remaining, self.quiet)
                    line.settimeout(max(remaining, 0.001))
                    part = line.recv(_PIECE)
                    if not part:
                        return Answer(octets, closed=True)
                    octets += part
                    if len(octets) > REPLY_LIMIT:
                        raise ProtocolError(E_TMOUT, "the answer does not end")
            except TIME_OVER:
                pass
            except OSError:
                return Answer(octets, closed=True)
        return Answer(octets, closed=False)

    def silent(self, octets: bytes) -> Answer:
        """Return the response to octets during the time in which the board should be quiet."""
        if self.address is None:
            raise SkipError("a serial line has no connection that could be closed")
        with self._connected(self.address) as line:
            line.sendall(octets)
            line.settimeout(self.quiet)
            try:
                answer = line.recv(_PIECE)
            except TIME_OVER:
                return Answer(b"", closed=False)
            except OSError:
                answer = b""
            return Answer(answer, closed=not answer)

    @contextmanager
    def stalled(self, octets: bytes) -> Iterator[None]:
        """Context in which a client is silent after some octets. Raises as `leave`."""
        if self.address is None:
            raise SkipError("a serial line has no connection that could be closed")
        with self._connected(self.address) as line:
            line.sendall(octets)
            yield

    def leave(self, octets: bytes) -> None:
        """Send octets and close the connection. Raises ConnectError, SkipError."""
        if self.address is None:
            raise SkipError("a serial line has no connection that could be closed")
        with self._connected(self.address) as line, suppress(OSError):
            line.sendall(octets)

    def _connected(self, address: tuple[str, int]) -> socket.socket:
        """Return a connection: a server may need a moment until it listens again.

        Raises ConnectError after the time-out of a response.
        """
        end, pause = monotonic() + self.answer, MIN_PAUSE
        while True:
            try:
                line = socket.create_connection(address, max(end - monotonic(), 1e-3))
            except OSError as error:
                if is_permanent(error) or monotonic() + pause >= end:
                    reason = error.strerror or error
                    raise ConnectError(f"no connection: {reason}") from error
            else:
                line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return line
            sleep(pause)
            pause = min(2 * pause, MAX_PAUSE)

    def absence(self) -> str | None:
        """Return why the board cannot be reached; None if it can."""
        try:
            if self.address is not None:
                self._connected(self.address).close()
                return None
            channel = self.channel()
            assert isinstance(channel, SerialChannel)
            channel.open()
            channel.close()
        except (ConnectError, ChannelError) as error:
            return str(error)
        return None
