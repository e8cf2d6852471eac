"""The command `rtgen rpc check`: compares a device's signature digest with a CDL file."""

from __future__ import annotations

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.cli.rpc.common import with_cdl, with_peer
from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.opaque_rpc import RpcError, peer_digest
from rtgen.runtime.opaque_rpc.serial import BAUDRATE
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.rpc.channels import channel_of
from rtgen.tools.rpc.signatures import CdlFiles, Peer, printed


@command("check")
@click.argument("words", metavar="[HOST:PORT] SIG", nargs=-1)
@click.option("--serial", metavar="DEV", help="Use a serial line.")
@click.option("--baud", type=WholeRange(min=1), default=BAUDRATE, show_default=True)
@with_cdl
@with_peer
@with_console
def check_(
    console: Console,
    cdl: CdlFiles,
    words: tuple[str, ...],
    serial: str | None,
    baud: int,
    peer: Peer,
) -> int:
    """Compare the digest of a device's signature with that of the CDL file.

    Prints both in one line of JSON. Exit code 1: the digests differ; 3: no response. Boards built
    without RTCPlugin.rb do not know the request, and close the connection.
    """
    address, rest = ((), words) if serial else (words[:1], words[1:])
    if len(rest) != 1:
        raise click.UsageError("give HOST:PORT or --serial DEV, and SIG")
    codec = cdl.service(rest[0], peer.wire).codec
    channel = channel_of(*address, serial=serial, baud=baud, peer=peer)
    try:
        digest = peer_digest(channel, codec)
    except RpcError as error:
        raise ToolError(f"{rest[0]}: {error}") from error
    finally:
        channel.close()
    answer = {"signature": codec.signature, "digest": codec.digest, "peer": digest}
    write_out(printed(answer))
    return OK if digest == codec.digest else NO
