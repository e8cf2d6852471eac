"""Channels to boards, by address."""

from __future__ import annotations

from rtgen.runtime.opaque_rpc import SerialChannel, TcpChannel
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.rpc.signatures import Peer


def channel_of(
    address: str = "", *, serial: str | None, baud: int, peer: Peer
) -> TcpChannel | SerialChannel:
    """Return the channel to a serial device or to HOST:PORT. Raises ClickException."""
    if serial:
        return SerialChannel(serial, baud, peer.timeout)
    return TcpChannel(*host_and_port(address), timeout=peer.timeout)


def host_and_port(text: str) -> tuple[str, int]:
    """Split HOST:PORT. Raises ClickException."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise Refusal(f"{text!r} is not HOST:PORT")
    return host.removeprefix("[").removesuffix("]"), int(port)
