"""Options shared by the commands."""

from __future__ import annotations

import errno
import functools
import os
import sys
from collections.abc import Callable
from typing import Concatenate, ParamSpec

import click

from rtgen.cli.help import LANGUAGE, MESSAGES, grouped
from rtgen.compiler.backends.kit.quoting import UnquotableError
from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.compiler.kit.project_file import interrupted_rename
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, FAILED, ReportedError

P = ParamSpec("P")


def with_console(
    function: Callable[Concatenate[Console, P], int],
) -> Callable[..., int]:
    """Add the options of the console; turn exceptions into diagnostics and exit codes."""

    @grouped(
        MESSAGES,
        click.option(
            "--diagnostics",
            "form",
            type=click.Choice(["text", "json", "sarif", "github"]),
            default="text",
            metavar="FORM",
            help="Diagnostics as text, json, sarif or github.",
        ),
        LANGUAGE,
        click.option("-q", "--quiet", is_flag=True, help="Print diagnostics only."),
        click.option(
            "--color",
            type=click.Choice(["auto", "always", "never"]),
            default="auto",
            metavar="WHEN",
            help="Colour of diagnostics: auto, always or never.",
        ),
    )
    @functools.wraps(function)
    def wrapped(
        form: str, quiet: bool, color: str, *args: P.args, **kwargs: P.kwargs
    ) -> int:
        console = Console(form, _in_colour(color), quiet)
        try:
            _complete_renames(console)
            return function(console, *args, **kwargs)
        except ReportedError as error:
            return error.code
        except InputError as error:
            console.findings(error.diagnostics)
            return BAD_INPUT
        except ToolError as error:
            if os.environ.get("RTGEN_DEBUG") == "1":
                raise
            from rtgen.compiler.project_rules import ENVIRONMENT

            console.findings([ENVIRONMENT.at(None, error.message, hint=error.hint)])
            return FAILED
        except UnquotableError as error:
            from rtgen.compiler.backends.kit.rules import UNQUOTABLE

            console.findings([UNQUOTABLE.at(None, str(error))])
            return BAD_INPUT
        except OSError as error:
            finding = _of_file(error)
            if finding is None:
                raise
            console.findings([finding])
            return FAILED if finding.code == "ENV0001" else BAD_INPUT
        finally:
            console.close()

    return wrapped


def _complete_renames(console: Console) -> None:
    """Complete a rename of the project here that was interrupted, and say so."""
    place = interrupted_rename()
    if place is None:
        return
    from rtgen.tools.renaming.interrupted import completed

    console.findings(completed(place))


def _of_file(error: OSError) -> Diagnostic | None:
    """Return the diagnostic for a file that cannot be used; None if the error names no file."""
    if (
        not isinstance(error.filename, str | bytes)
        or os.environ.get("RTGEN_DEBUG") == "1"
    ):
        return None
    from rtgen.compiler.project import path_finding
    from rtgen.compiler.project_rules import ENVIRONMENT

    name = os.fsdecode(error.filename)
    if (
        error.errno == errno.ENAMETOOLONG
        and (finding := path_finding(name)) is not None
    ):
        return finding
    return ENVIRONMENT.at(None, f"cannot use {name}: {error.strerror}")


def _in_colour(choice: str) -> bool:
    if choice != "auto":
        return choice == "always"
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    forced = os.environ.get("FORCE_COLOR")
    return sys.stderr.isatty() if forced is None else forced != ""
