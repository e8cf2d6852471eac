"""Interface of channels for callers, types of their servers, and a channel without a connection."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol, TypeAlias

from rtgen.runtime.opaque_rpc.errors import E_BOVR, ChannelError

More: TypeAlias = Callable[[int], bytes]
"""Returns exactly n octets of the message, or raises ChannelError."""

Handler: TypeAlias = Callable[[More], bytes | None]
"""Serves a request whose first octets have been read; returns the reply, None of a oneway one."""

Handlers: TypeAlias = Mapping[bytes, Handler]
"""Handlers by SOP and function id as they are on the wire."""


class Channel(Protocol):
    """Carries one call at a time; the operations of `OpaqueRpc.idl`.

    A call is `begin`, any number of `more`, then exactly one of `end` and `reset`. When `begin`
    raises, the channel is free already and neither may follow. All raise `ChannelError`.
    """

    def begin(self, request: bytes, first: int) -> bytes:
        """Take the channel, writes the request in one send; the reply's leading `first` bytes.

        `first` is 0 where no reply is awaited. Nothing is ever sent twice.
        """

    def more(self, n: int) -> bytes:
        """Return the next n bytes of the reply."""

    def end(self) -> None:
        """The reply was read to its end: frees the channel."""

    def reset(self) -> None:
        """The call failed: no later call will see any of this reply. Frees the channel."""


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
