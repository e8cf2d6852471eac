"""The command `rtgen rpc encode`: prints the octets of a request or a reply."""

from __future__ import annotations

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.rpc.common import with_cdl, with_representation
from rtgen.runtime.opaque_rpc import ArgumentError
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK, Refusal
from rtgen.tools.rpc.codecs import Function
from rtgen.tools.rpc.signatures import CdlFiles, Wire, parsed
from rtgen.tools.rpc.values import JsonError


@command("encode")
@click.argument("function", metavar="SIG.FUNC")
@click.option("--request", metavar="JSON", help="The arguments.")
@click.option("--reply", metavar="JSON", help="Return value and outs.")
@with_cdl
@with_representation
@with_console
def encode_(
    console: Console,
    cdl: CdlFiles,
    function: str,
    request: str | None,
    reply: str | None,
    wire: Wire,
) -> int:
    """Print the bytes of a request or a reply in hex.

    With both options, it is the reply to that request. Some replies depend on sizes and NULL
    arguments of their request; by default, sizes fit the values, and no argument is NULL.
    """
    called = cdl.function(function, wire)
    try:
        data = _encoded(called, request, reply)
    except (ArgumentError, JsonError) as error:
        raise Refusal(str(error)) from error
    write_out(f"{data.hex()}\n")
    return OK


def _encoded(function: Function, request: str | None, reply: str | None) -> bytes:
    arguments = None
    if request is not None:
        arguments = function.arguments_from_json(parsed(request))
    if reply is None:
        if arguments is None:
            raise Refusal("give --request or --reply")
        return function.encode_request(arguments)
    if function.oneway:
        raise Refusal(f"{function.name} is oneway: it has no reply")
    returned, outs = function.result_from_json(parsed(reply))
    if arguments is not None:
        return function.encode_reply(function.kept(arguments), returned, outs)
    longest = max((len(o) for o in outs if isinstance(o, list | bytes)), default=0)
    return function.guessed(
        longest, lambda kept: function.encode_reply(kept, returned, outs)
    )
