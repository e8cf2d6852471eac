"""Digest of a signature on the wire: whether a peer was generated from the same signature.

It is requested by function 32767, the highest id, which signatures do not use because ids count
from 1. Unmarshallers of rtgen and boards built with `RTCPlugin.rb` answer it; other boards treat it
as an unknown function and close the connection, so it is only requested on demand.
docs/opaque-rpc.md describes the messages.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.opaque_rpc.channel import Channel, Handler, More
from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.opaque_rpc.errors import E_MAGIC, ProtocolError
from rtgen.runtime.opaque_rpc.tdr import SOP_REPLY

DIGEST: Final = 0x7FFF
"""The id of the function that answers with the digest."""

_SIZE = 8
_MARK = 2


def peer_digest(channel: Channel, codec: Codec) -> str:
    """Request a peer's digest of its signature, 16 hexadecimal digits.

    Raises ChannelError without an answer, ProtocolError for an unexpected one.
    """
    request = codec.request_head(DIGEST) + codec.awaiting_reply
    reply = channel.begin(request, _MARK + _SIZE + _MARK)
    start, end = reply[:_MARK], reply[-_MARK:]
    if start != codec.tdr.int16(SOP_REPLY) or end != codec.nothing_follows:
        channel.reset()
        raise ProtocolError(
            E_MAGIC, f"{codec.signature}: no answer with a digest: {reply.hex(' ')}"
        )
    channel.end()
    value = int.from_bytes(reply[_MARK:-_MARK], codec.tdr.byte_order)
    return f"{value:0{2 * _SIZE}x}"


def check_signature(channel: Channel, codec: Codec) -> None:
    """Compare the digest of a peer with that of the codec.

    Raises ProtocolError (E_MAGIC) if the peer was made from another signature, such as one with
    two parameters swapped, and what `peer_digest` raises.
    """
    digest = peer_digest(channel, codec)
    if digest != codec.digest:
        raise ProtocolError(
            E_MAGIC,
            f"{codec.signature}: the peer was made from another signature "
            f"(digest {digest}, here {codec.digest})",
        )


def digest_handler(codec: Codec) -> Handler:
    """Return the handler of the request in a server."""
    tdr = codec.tdr
    value = int(codec.digest, 16).to_bytes(_SIZE, tdr.byte_order)
    reply = tdr.int16(SOP_REPLY) + value + codec.nothing_follows

    def handle(more: More) -> bytes:
        end = more(_MARK)
        if end != codec.awaiting_reply:
            raise ProtocolError(
                E_MAGIC, f"{codec.signature}: no question for a digest: {end.hex(' ')}"
            )
        return reply

    return handle
