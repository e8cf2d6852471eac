"""The command line: one module for each command, imported when it is called."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Sequence

import click

from rtgen.cli.groups import SectionedGroup
from rtgen.cli.help import HELP, language_of
from rtgen.compiler.kit import translation
from rtgen.facts.version import __version__
from rtgen.tools.kit.exits import BAD_INPUT, Refusal

SECTIONS = {
    "write": {
        "new": "Create a project, or add a part to one.",
        "generate": "Generate files from definitions.",
        "fmt": "Format definitions.",
        "check": "Check that generated files are up to date.",
        "diff": "Compare two versions of definitions.",
    },
    "run": {
        "run": "Run a system on the embedded runtime.",
        "ui": "Show a system in a browser; wire, drive, watch it.",
        "ctl": "Watch and control components of other processes.",
        "log": "Show, export, compare and play recorded runs.",
    },
    "devices": {
        "can": "Monitor CAN buses, access their nodes, or run a bus.",
        "rpc": "Call functions of TECS devices.",
        "conformance": "Test a device, board or component by its definition.",
    },
    "files": {
        "convert": "Convert components and systems, or adopt a component.",
        "docs": "Generate a documentation site.",
        "graph": "Draw a system's components and connections as SVG.",
    },
    "more": {
        "lint": "Run the lint rules on definitions.",
        "inspect": "Show the resolved model of definitions or systems.",
        "replay": "Replay a recorded run into a system.",
        "explain": "Explain a diagnostic.",
        "lsp": "Run the language server for editors.",
    },
}
"""Commands by section, with their help lines; a module has a function, both with that name."""
COMMANDS = {n: text for section in SECTIONS.values() for n, text in section.items()}


@click.group(
    cls=SectionedGroup,
    sections=SECTIONS,
    target="rtgen.cli.{0}:{0}",
    hidden=frozenset({"adopt"}),
    context_settings=HELP,
)
@click.version_option(__version__, prog_name="rtgen", message="%(prog)s %(version)s")
def application() -> None:
    """An interface compiler for robot software, from definitions to running code."""


_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)


def run(arguments: Sequence[str], *, ends: bool = False) -> int:
    """Run a command line; return its exit code and raise nothing.

    `ends`: the process ends with the command, so garbage collection is disabled.
    """
    with translation.of_command(_language_of_project, language_of(arguments)):
        return _run(arguments, ends=ends)


def _run(arguments: Sequence[str], *, ends: bool) -> int:
    try:
        if any("\0" in each for each in arguments):
            raise click.UsageError("an argument has no null character")
        code = application.main(
            list(arguments), prog_name="rtgen", standalone_mode=False, obj=ends
        )
        sys.stdout.flush()
    except click.ClickException as error:
        _show(error)
        return error.exit_code
    except Refusal as error:
        _show(click.ClickException(str(error)))
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        from rtgen.tools.kit.exits import INTERRUPTED

        return INTERRUPTED
    except BrokenPipeError as error:
        return _ended_by(error)
    except OSError as error:
        return _unwritable(error) if error.errno in _NO_ROOM else _internal(error)
    except Exception as error:
        return _internal(error)
    return code if isinstance(code, int) else 0


def _show(error: click.ClickException) -> None:
    """Print an error of usage as click does, in the language."""
    from io import StringIO

    text = StringIO()
    error.show(file=text)
    click.echo(translation.translated_lines(text.getvalue()), err=True, nl=False)


def _language_of_project() -> str | None:
    from rtgen.compiler.kit.project_file import language_of_project

    return language_of_project()


def _ended_by(error: BrokenPipeError) -> int:
    """Return the exit code after a reader of the output has gone."""
    from rtgen.runtime.failures import ends_run
    from rtgen.tools.kit.console import discard_unread
    from rtgen.tools.kit.exits import NO

    if not ends_run(error):
        return _internal(error)
    discard_unread()
    return NO


def _unwritable(error: OSError) -> int:
    """Return the exit code if a disk is full or fails; only standard output has no file name."""
    name = error.filename or "standard output"
    severity = translation.translated_word("error")
    what = translation.translated(f"cannot write {name}: {error.strerror}")
    click.echo(f"{severity}[ENV0001]: {what}", err=True)
    if error.filename is None:
        # Buffered output must not fail again at process exit.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
    return 3


def _internal(error: Exception) -> int:
    if os.environ.get("RTGEN_DEBUG") == "1":
        raise error
    from rtgen.compiler.diagnostics.printable import printable

    text = printable(" ".join(f"{type(error).__name__}: {error}".split()))
    message = f"rtgen: internal error: {text}; please report it"
    click.echo(translation.translated(message), err=True)
    return 3
