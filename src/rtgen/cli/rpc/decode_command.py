"""The command `rtgen rpc decode`: prints the values in a request or a reply."""

from __future__ import annotations

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.rpc.common import with_cdl, with_representation
from rtgen.runtime.opaque_rpc import RpcError
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK, Refusal
from rtgen.tools.rpc.codecs import Function
from rtgen.tools.rpc.signatures import (
    CdlFiles,
    Wire,
    octets,
    printed,
)
from rtgen.tools.rpc.values import Json


@command("decode")
@click.argument("function", metavar="SIG.FUNC")
@click.option("--request", metavar="HEX", help="The bytes of a request.")
@click.option("--reply", metavar="HEX", help="The bytes of a reply.")
@with_cdl
@with_representation
@with_console
def decode_(
    console: Console,
    cdl: CdlFiles,
    function: str,
    request: str | None,
    reply: str | None,
    wire: Wire,
) -> int:
    """Print the values in the bytes of a request or a reply as JSON.

    With both options, it is the reply to that request. Some replies depend on sizes and NULL
    arguments of their request; by default, sizes fit the values, and no argument is NULL.
    """
    called = cdl.function(function, wire)
    try:
        value = _decoded(called, request, reply)
    except RpcError as error:
        raise Refusal(str(error)) from error
    write_out(printed(value))
    return OK


def _decoded(function: Function, request: str | None, reply: str | None) -> Json:
    arguments = None
    if request is not None:
        arguments = function.decode_request(octets(request))
    if reply is None:
        if arguments is None:
            raise Refusal("give --request or --reply")
        return function.arguments_to_json(arguments)
    if function.oneway:
        raise Refusal(f"{function.name} is oneway: it has no reply")
    data = octets(reply)
    if arguments is not None:
        kept = function.kept(arguments)
        return function.result_to_json(*function.decode_reply(data, kept))
    return function.guessed(
        len(data),
        lambda kept: function.result_to_json(*function.decode_reply(data, kept)),
    )
