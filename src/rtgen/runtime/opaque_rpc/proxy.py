"""What generated proxies do with a channel."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, TypeVarTuple

from rtgen.runtime.opaque_rpc.channel import Channel
from rtgen.runtime.opaque_rpc.codecs import More

_Kept = TypeVarTuple("_Kept")
_T = TypeVar("_T")


def call(
    channel: Channel,
    request: bytes,
    first: int,
    read: Callable[[bytes, More, *_Kept], _T],
    *kept: *_Kept,
) -> _T:
    """Sends a request and reads its reply, whose first bytes can be asked for at once.

    Raises ChannelError and ProtocolError; the channel is free then, as after a call.
    """
    head = channel.begin(request, first)
    try:
        result = read(head, channel.more, *kept)
    except BaseException:
        channel.reset()
        raise
    channel.end()
    return result


def send(channel: Channel, request: bytes) -> None:
    """Sends the request of a oneway function. Raises ChannelError."""
    channel.begin(request, 0)
    channel.end()
