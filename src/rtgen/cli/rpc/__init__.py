"""`rtgen rpc`: calls of TECS functions from the command line."""

from __future__ import annotations

from importlib import import_module

import click

COMMANDS = {
    "list": "List the functions of the signatures.",
    "call": "Call a function of a device.",
    "encode": "Print the bytes of a request or a reply.",
    "decode": "Print the values in a request or a reply.",
    "serve": "Stand in for a device.",
    "replay": "Compare recorded calls with freshly generated codecs.",
}
"""Command to its line of help; the module `<command>_command` has a function `<command>_`."""


class _Commands(click.Group):
    """The commands, imported one by one as needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module = import_module(f"rtgen.cli.rpc.{cmd_name}_command")
        command = getattr(module, f"{cmd_name}_")
        assert isinstance(command, click.Command)
        return command

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_Commands)
def rpc() -> None:
    """Call the functions of TECS devices, or look at the bytes of such calls.

    Values are JSON as in recorded calls: arguments an object by name; a reply
    {"return": ..., "outs": {...}}; characters 0 to 255; inf, -inf and nan as text.
    """
