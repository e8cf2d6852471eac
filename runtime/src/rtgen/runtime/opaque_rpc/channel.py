"""Interfaces of channels and request handlers, and a channel without a connection."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol, TypeAlias

from rtgen.runtime.opaque_rpc.errors import E_BOVR, ChannelError

More: TypeAlias = Callable[[int], bytes]
"""Function that returns exactly n octets of the message. Raises ChannelError."""

Handler: TypeAlias = Callable[[More], bytes | None]
"""Function that serves a request, after its first octets; returns the reply, None if oneway."""

Handlers: TypeAlias = Mapping[bytes, Handler]
"""Handlers by SOP and function id as sent on the wire."""


class Channel(Protocol):
    """Transports one call at a time; the operations of `OpaqueRpc.idl`.

    A call is `begin`, any number of `more`, then exactly one of `end` and `reset`. If `begin`
    raises, the channel is free and neither may follow. All raise `ChannelError`.
    """

    def begin(self, request: bytes, first: int) -> bytes:
        """Allocate the channel and send the request at once; return the reply's first octets.

        Their number is `first`, 0 if there is no reply. Nothing is ever sent twice.
        """

    def more(self, n: int) -> bytes:
        """Return the next n bytes of the reply."""

    def end(self) -> None:
        """Free the channel after the complete reply was read."""

    def reset(self) -> None:
        """Free the channel after a failed call; later calls will not see the rest of its reply."""


class ExchangeChannel:
    """A channel over a function that maps a request packet to the complete reply.

    For servers in the same process: `ExchangeChannel(PacketServer(unmarshaller.handlers))`. The
    function raises `ChannelError` if the reply is incomplete or the link is down.
    """

    def __init__(self, exchange: Callable[[bytes], bytes]) -> None:
        self._exchange = exchange
        self._reply = b""
        self._at = 0

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`."""
        self._reply = self._exchange(request)
        self._at = 0
        return self.more(first)

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        data = self._reply[self._at : self._at + n]
        if len(data) < n:
            raise ChannelError(E_BOVR, f"the reply ended {n - len(data)} bytes early")
        self._at += n
        return data

    def end(self) -> None:
        """See `Channel`."""
        self._reply = b""

    def reset(self) -> None:
        """See `Channel`."""
        self._reply = b""
