"""The command `rtgen rpc call`: calls a function of a device."""

from __future__ import annotations

from typing import cast

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.cli.rpc.common import with_cdl, with_peer
from rtgen.compiler.diagnostics import ToolError
from rtgen.runtime.opaque_rpc import (
    ArgumentError,
    RpcError,
)
from rtgen.runtime.opaque_rpc.serial import BAUDRATE
from rtgen.runtime.opaque_rpc.values import is_rpc_error
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import FAILED, OK, Refusal
from rtgen.tools.rpc.channels import channel_of
from rtgen.tools.rpc.codecs import Function
from rtgen.tools.rpc.signatures import (
    CdlFiles,
    Peer,
    parsed,
    printed,
)
from rtgen.tools.rpc.values import JsonError


@command("call")
@click.argument("words", metavar="[HOST:PORT] SIG.FUNC [JSON]", nargs=-1)
@click.option("--serial", metavar="DEV", help="Use a serial line.")
@click.option("--baud", type=WholeRange(min=1), default=BAUDRATE, show_default=True)
@with_cdl
@with_peer
@with_console
def call_(
    console: Console,
    cdl: CdlFiles,
    words: tuple[str, ...],
    serial: str | None,
    baud: int,
    peer: Peer,
) -> int:
    """Call a function of a device and print the result.

    JSON is the object of the arguments, by default {}. The output is {"return": ..., "outs": {...}}
    in one line. Exit code 3: the call failed in transport; if the function returns ER, the error
    code is still printed.
    """
    address, rest = ((), words) if serial else (words[:1], words[1:])
    if not 1 <= len(rest) <= 2:
        raise click.UsageError("give HOST:PORT or --serial DEV, SIG.FUNC, and JSON")
    name, text = rest[0], rest[1] if len(rest) > 1 else "{}"
    function = cdl.function(name, peer.wire)
    channel = channel_of(*address, serial=serial, baud=baud, peer=peer)
    try:
        arguments = function.arguments_from_json(parsed(text))
        returned, outs = function.call(channel, arguments)
    except (ArgumentError, JsonError) as error:
        raise Refusal(str(error)) from error
    except RpcError as error:
        if _returns_code(function):
            write_out(printed({"return": error.code, "outs": None}))
        raise ToolError(f"{name}: {error}") from error
    finally:
        channel.close()
    write_out(printed(function.result_to_json(returned, outs)))
    failed = _returns_code(function) and is_rpc_error(cast(int, returned))
    return FAILED if failed else OK


def _returns_code(function: Function) -> bool:
    """Return whether the return value reports failures: its declared type is ER or ER_INT."""
    return str(function.layout.function.returns) in ("ER", "ER_INT")
