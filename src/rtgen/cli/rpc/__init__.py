"""The command group `rtgen rpc`: calls of TECS functions from the command line."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS = {
    "list": "List the functions of the signatures.",
    "call": "Call a function of a device.",
    "check": "Compare the signature of a device with that of a CDL file.",
    "encode": "Print the bytes of a request or a reply.",
    "decode": "Print the values in a request or a reply.",
    "serve": "Simulate a device.",
    "replay": "Compare recorded calls with newly generated codecs.",
}
"""Commands with their help lines; module `<command>_command` has a function `<command>_`."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.rpc.{0}_command:{0}_")
def rpc() -> None:
    """Call the functions of TECS devices, or inspect the bytes of calls.

    Values are JSON as in recorded calls: arguments are an object by name; a reply is
    {"return": ..., "outs": {...}}; characters are 0 to 255; inf, -inf and nan are text.
    """
