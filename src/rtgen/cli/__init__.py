"""The command line: one module for each command, loaded when it is called."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

import click

from rtgen import __version__

COMMANDS = {
    "generate": "Make the files that the definitions ask for.",
    "check": "Compare the tree with what generate would make.",
    "lint": "Look for what is better done otherwise.",
    "inspect": "Show the resolved model of definitions or systems.",
    "run": "Run a system on the embedded runtime.",
    "graph": "Draw a system's components and connections as SVG.",
    "rpc": "Call functions of TECS devices, or look at the bytes of such calls.",
    "explain": "Tell what a diagnostic means.",
}
"""Command to its line of help; the module of the same name has a function of the same name."""

_INTERRUPTED = 130


class _Commands(click.Group):
    """The commands, imported one by one as needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = getattr(import_module(f"rtgen.cli.{cmd_name}"), cmd_name)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            from difflib import get_close_matches

            close = get_close_matches(args[0], COMMANDS, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            ctx.fail(f"No such command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="rtgen", message="%(prog)s %(version)s")
def application() -> None:
    """An interface compiler for robot software: definitions in, running Python out.

    Exit codes: 0 done, 1 the answer is no, 2 the input has errors, 3 the environment failed.
    """


def main() -> None:
    """The program `rtgen`."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Runs a command line and returns its exit code; nothing but that leaves it."""
    try:
        code = application.main(
            list(arguments), prog_name="rtgen", standalone_mode=False
        )
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        return _INTERRUPTED
    except Exception as error:
        if os.environ.get("RTGEN_DEBUG") == "1":
            raise
        text = " ".join(f"{type(error).__name__}: {error}".split())
        click.echo(f"rtgen: internal error: {text}; please report it", err=True)
        return 3
    return code if isinstance(code, int) else 0
