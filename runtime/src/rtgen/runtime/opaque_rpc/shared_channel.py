"""The caller's side of a shared channel: several signatures on one connection."""

from __future__ import annotations

from typing import Literal, Protocol

from rtgen.runtime.opaque_rpc.channel import Channel
from rtgen.runtime.opaque_rpc.errors import ChannelError
from rtgen.runtime.opaque_rpc.messages import log
from rtgen.runtime.opaque_rpc.tdr import SHARED_BEGIN, SHARED_END


class StreamChannel(Channel, Protocol):
    """A channel that can send bytes after a reply, such as TCP and serial channels."""

    def write(self, data: bytes) -> None:
        """Write data of the current call. Raises ChannelError."""


class SharedChannel:
    """Sub-channel `number` of a connection (opaque-rpc-wire, section 12). See `Channel`.

    Sub-channels count from 0, in the order in which their joins were made. All that share a
    connection use the same `channel`, which allows one call at a time. `order` is that of the
    representation, the native one of the peer.
    """

    def __init__(
        self,
        channel: StreamChannel,
        number: int,
        order: Literal["little", "big"] = "little",
    ) -> None:
        self._channel = channel
        begin, self._end = (m.to_bytes(2, order) for m in (SHARED_BEGIN, SHARED_END))
        self._start = begin + number.to_bytes(2, order)
        self._open = False

    def begin(self, request: bytes, first: int) -> bytes:
        """See `Channel`."""
        if not first:
            return self._channel.begin(self._start + request + self._end, 0)
        data = self._channel.begin(self._start + request, first)
        self._open = True
        return data

    def more(self, n: int) -> bytes:
        """See `Channel`."""
        return self._channel.more(n)

    def end(self) -> None:
        """See `Channel`. The reply is complete, so an error now only closes the connection."""
        if self._open:
            self._open = False
            try:
                self._channel.write(self._end)
            except ChannelError as error:
                log.info("after a reply: %s", error)
                self._channel.reset()
                return
        self._channel.end()

    def reset(self) -> None:
        """See `Channel`."""
        self._open = False
        self._channel.reset()
