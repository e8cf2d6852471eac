"""What generated proxies do with a channel, beside what they spell out."""

from __future__ import annotations

from rtgen.runtime.opaque_rpc.channel import Channel


def send(channel: Channel, request: bytes) -> None:
    """Sends the request of a oneway function. Raises ChannelError."""
    channel.begin(request, 0)
    channel.end()
