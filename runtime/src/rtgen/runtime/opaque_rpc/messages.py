"""The server's message loop, without I/O: receives octets, calls handlers, returns replies."""

from __future__ import annotations

import logging
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Final, Literal, Protocol, TypeAlias

from rtgen.runtime.failures import described, ends_run
from rtgen.runtime.opaque_rpc.channel import Handler, Handlers, More
from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.opaque_rpc.digest import DIGEST, digest_handler
from rtgen.runtime.opaque_rpc.errors import (
    E_BOVR,
    E_ID,
    E_MAGIC,
    E_NOMEM,
    ChannelError,
    ProtocolError,
    RpcError,
)
from rtgen.runtime.opaque_rpc.tdr import SHARED_BEGIN, SHARED_END
from rtgen.runtime.requests import await_turn, charge

Send: TypeAlias = Callable[[bytes], None]

HEAD: Final = 4
"""Number of octets that select a message's handler: SOP and function id."""
_SOP = 2

log = logging.getLogger("rtgen.runtime.opaque_rpc")


class Unmarshaller(Protocol):
    """Interface of generated unmarshallers: handlers by the first 4 octets of their requests.

    A handler reads the rest of the request, checks its end, calls the target, and returns the
    reply, or None for a oneway function.
    """

    @property
    def handlers(self) -> Handlers:
        """Handlers by SOP and function id as sent on the wire."""


class Dispatcher:
    """Base class of generated unmarshallers, which call the target's method for each function.

    Raises TypeError if the target does not have one.
    """

    def __init__(self, target: object, codec: Codec) -> None:
        self.target = target
        self.codec = codec
        missing = [n for n in codec.functions if not callable(getattr(target, n, None))]
        if missing:
            raise TypeError(
                f"{type(target).__name__} does not define {', '.join(missing)}"
            )
        self.handlers: Handlers = {
            codec.request_head(function.id): function.handler(getattr(target, name))
            for name, function in codec.functions.items()
        }
        if codec.digest:
            head = codec.request_head(DIGEST)
            self.handlers = {**self.handlers, head: digest_handler(codec)}


class MessageReader(ABC):
    """Buffered reader of requests. At most `limit` bytes of a message are read.

    Without it, only the codec limits the length of a message.
    """

    def __init__(self, limit: int | None = None) -> None:
        self._data = b""
        self._at = 0
        self._ready = 0
        self._start = 0
        self._limit = sys.maxsize if limit is None else limit
        self._deadline: float | None = None

    @abstractmethod
    def _wait(self) -> bytes:
        """Wait for the first bytes of a message; return them, empty at the end of the stream."""

    @abstractmethod
    def _receive(self, size: int) -> bytes:
        """Receive up to `size` bytes of an incomplete message; empty at the end of the stream."""

    def head(self, n: int) -> bytes:
        """Wait for a message; return its first n bytes, or those received.

        Empty at the end of the stream. Size and time of the message are counted from now.
        """
        at = self._at
        if at < len(self._data):
            return self._begin(self._data, at, n)
        return self._begin(self._wait(), 0, n)

    def serve(self, handlers: Handlers, send: Send) -> None:
        """Serve requests until the stream ends. Raises what `serve_message` raises."""
        next_head, more, find = self.head, self.more, handlers.get
        while head := next_head(HEAD):
            handler = find(head) or find_handler(head, more, handlers)
            begun = await_turn()
            reply = handler(more)
            if reply is not None:
                send(reply)
            charge(begun)

    def more(self, n: int) -> bytes:
        """Return the next n bytes of the message.

        Raises ProtocolError (E_NOMEM) before anything is read if the message is larger than the
        limit, ChannelError (E_BOVR) at the end of the stream.
        """
        at = self._at
        end = at + n
        if end > self._ready:
            return self._more(n)
        self._at = end
        return self._data[at:end]

    def _begin(self, data: bytes, at: int, n: int) -> bytes:
        """Start a message at `at`; return its first n bytes, or those received."""
        self._data = data
        self._deadline = None
        self._start = at
        size = len(data)
        self._ready = size if size - at <= self._limit else at + self._limit
        head = data[at : at + n]
        self._at = at + len(head)
        return head

    def _more(self, n: int) -> bytes:
        have = self._at - self._start
        if have + n > self._limit:
            raise ProtocolError(
                E_NOMEM, f"a request larger than {self._limit} bytes (PPAllocatorSize)"
            )
        pieces = [self._data[self._at :]]
        missing = n - len(pieces[0])
        while missing > 0:
            piece = self._receive(missing)
            if not piece:
                raise ChannelError(E_BOVR, "the stream ended inside a request")
            pieces.append(piece)
            missing -= len(piece)
        self._data = b"".join(pieces)
        self._at = n
        self._start = -have
        self._ready = min(len(self._data), self._limit - have)
        return self._data[:n]


class PacketReader(MessageReader):
    """Reads requests from a packet."""

    def __init__(self, packet: bytes, limit: int | None = None) -> None:
        super().__init__(limit)
        self._data = packet

    def _wait(self) -> bytes:
        return b""

    def _receive(self, size: int) -> bytes:
        return b""


def serve_message(reader: MessageReader, handlers: Handlers) -> bytes | None:
    """Wait for a message and serve it; return its reply, None if it is oneway.

    Raises ProtocolError and ChannelError; the function was then not executed.
    """
    handler = find_handler(reader.head(HEAD), reader.more, handlers)
    return handler(reader.more)


def find_handler(head: bytes, more: More, handlers: Handlers) -> Handler:
    """Return the handler of a message whose head may be incomplete or wrong.

    A wrong octet is reported immediately, without waiting for the rest of the head.
    """
    while (handler := handlers.get(head)) is None:
        if not any(key.startswith(head[:_SOP]) for key in handlers):
            raise ProtocolError(E_MAGIC, f"no start of a request: {head.hex(' ')}")
        if len(head) == HEAD:
            raise ProtocolError(E_ID, f"unknown function id: {head[_SOP:].hex(' ')}")
        head += more(1)
    return handler


class SharedUnmarshaller:
    """Serves several signatures on one connection (SharedOpaqueRPC), by sub-channel number.

    Octets that start no exchange are skipped in steps of 2, and an error inside an exchange does
    not end the connection. `order` is the byte order of the representation: the native one of the
    peer.
    """

    def __init__(
        self,
        unmarshallers: Sequence[Unmarshaller],
        order: Literal["little", "big"] = "little",
    ) -> None:
        self._handlers = [unmarshaller.handlers for unmarshaller in unmarshallers]
        self._order: Literal["little", "big"] = order

    @property
    def starts(self) -> set[bytes]:
        """The first 2 bytes of an exchange."""
        return {SHARED_BEGIN.to_bytes(2, self._order)}

    def serve(self, reader: MessageReader, send: Send) -> None:
        """Serve requests until the stream ends or fails (ChannelError)."""
        while head := reader.head(2):
            try:
                self._exchange(head, reader, send)
            except ProtocolError as error:
                log.info("ignored: %s", error)

    def _exchange(self, head: bytes, reader: MessageReader, send: Send) -> None:
        self._expect(head + reader.more(2 - len(head)), SHARED_BEGIN)
        number = int.from_bytes(reader.more(2), self._order, signed=True)
        if not 0 <= number < len(self._handlers):
            raise ProtocolError(E_ID, f"unknown sub-channel {number}")
        handler = find_handler(reader.more(HEAD), reader.more, self._handlers[number])
        begun = await_turn()
        reply = handler(reader.more)
        if reply is not None:
            send(reply)
        charge(begun)
        self._expect(reader.more(2), SHARED_END)

    def _expect(self, data: bytes, magic: int) -> None:
        word = int.from_bytes(data, self._order)
        if word != magic:
            raise ProtocolError(
                E_MAGIC, f"0x{word:04X} in place of 0x{magic:04X} of a shared channel"
            )


Service: TypeAlias = Unmarshaller | SharedUnmarshaller


def starts(service: Service) -> set[bytes]:
    """Return the first 2 bytes of messages to the service."""
    if isinstance(service, SharedUnmarshaller):
        return service.starts
    return {key[:_SOP] for key in service.handlers}


def serve(
    service: Service, reader: MessageReader, send: Send, peer: str = "a client"
) -> bool:
    """Serve a connection; return whether it ended regularly.

    False: an error of the peer or of the target, which is logged with the name of the peer; the
    connection cannot be used for further messages.
    """
    try:
        if isinstance(service, SharedUnmarshaller):
            service.serve(reader, send)
        else:
            reader.serve(service.handlers, send)
    except RpcError as error:
        log.warning("connection with %s given up: %s", peer, error)
        return False
    except BaseException as error:
        if ends_run(error):
            raise
        log.error(
            "a call from %s failed and has no reply: %s",
            peer,
            described(error),
            exc_info=error,
        )
        return False
    return True


class PacketServer:
    """Serves packets in the caller's thread: the function for an `ExchangeChannel`.

    A packet for which the server would close the connection raises ChannelError.
    """

    def __init__(self, service: Service, limit: int | None = None) -> None:
        self._service = service
        self._limit = limit

    def __call__(self, packet: bytes) -> bytes:
        """Return the replies to the requests of a packet, one after the other."""
        replies: list[bytes] = []
        if not serve(self._service, PacketReader(packet, self._limit), replies.append):
            raise ChannelError(E_BOVR, "the server closed the connection")
        return b"".join(replies)
