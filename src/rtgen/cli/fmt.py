"""The command `rtgen fmt`: puts IDL, CDL and bus files in their form."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import click

from rtgen.cli.definition_options import with_encoding
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.diagnostics import Diagnostic, InputError, has_errors
from rtgen.compiler.frontends.kit.library import MAX_BYTES
from rtgen.compiler.project import Project, load, shown
from rtgen.compiler.project import files as files_below
from rtgen.compiler.project.output import MANIFEST, Change
from rtgen.compiler.project.rewriting import rewrite
from rtgen.facts.extras import installation
from rtgen.facts.files import UnreadableError, read_file
from rtgen.tools.can.common import counted
from rtgen.tools.fmt import Options, toml
from rtgen.tools.fmt.files import SUFFIXES, check_name, format_bytes
from rtgen.tools.fmt.rules import NO_FORMATTER, OTHER_FILE
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK

_STANDARD_INPUT = "-"
_RANGE = re.compile(r"(\d{1,9}):(\d{1,9})")


def _lines(
    context: click.Context, parameter: click.Parameter, value: str | None
) -> tuple[int, int] | None:
    if value is None:
        return None
    match = _RANGE.fullmatch(value)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise click.BadParameter("write it FIRST:LAST, from 1", context, parameter)
    return int(match[1]), int(match[2])


@command()
@click.argument("paths", nargs=-1, metavar="[PATH|-]...")
@click.option("--check", is_flag=True, help="List the files that are not formatted.")
@click.option("--diff", "as_diff", is_flag=True, help="Print a unified diff instead.")
@click.option(
    "--range",
    "lines",
    metavar="FIRST:LAST",
    callback=_lines,
    help="Format only the statements in these lines of a single file.",
)
@click.option(
    "--stdin-filename",
    metavar="FILE",
    default="stdin.idl",
    show_default=True,
    help="File name of standard input: selects the format, and appears in diagnostics.",
)
@with_encoding
@with_console
def fmt(
    console: Console,
    paths: tuple[str, ...],
    check: bool,
    as_diff: bool,
    lines: tuple[int, int] | None,
    stdin_filename: str,
    encoding: str | None,
) -> int:
    """Format IDL, CDL and bus files: indentation, spaces, line ends.

    PATH is a file, a folder with such files below it, or - for standard input; the default is the
    sources of rtgen.toml. Comments, preprocessor lines and tokens are not changed. Exit code 0:
    done; 1: --check or --diff found files that are not formatted; 2: errors, and the files with
    errors are left as they are.
    """
    project = load()
    options = Options(**{k.replace("-", "_"): v for k, v in project.form.items()})
    form = _Form(options, encoding or project.encoding, lines)
    if _STANDARD_INPUT in paths:
        if len(paths) > 1:
            raise click.UsageError("standard input is formatted alone")
        return _format_input(form, Path(stdin_filename), check=check, as_diff=as_diff)
    files = [*_files(project, paths)]
    if lines is not None and len(files) != 1:
        raise click.UsageError("--range is for a single file")
    keeps = check or as_diff
    changes: list[Change] = []
    diagnostics: list[Diagnostic] = []
    named = {*map(Path, paths)}
    for path in files:
        try:
            change = _change(form, path, is_named=path in named)
        except InputError as error:
            diagnostics += error.diagnostics
            continue
        if change.new != change.old:
            # At once: the longer it takes, the likelier someone else changes the file.
            if not keeps:
                rewrite(change)
                console.say(f"formatted {shown(path)}")
            changes.append(change)
    console.findings(diagnostics)
    if has_errors(diagnostics):
        return BAD_INPUT
    if keeps:
        _print(changes, as_diff)
        return NO if changes else OK
    unchanged = len(files) - len(changes)
    console.say(
        f"{counted(len(changes), 'file')} formatted, {unchanged} left as they are"
    )
    return OK


def _format_input(form: _Form, name: Path, *, check: bool, as_diff: bool) -> int:
    """Format standard input, a file with a name, and return the exit code."""
    data = sys.stdin.buffer.read(MAX_BYTES + 1)
    change = form.change(name, data)
    if not (check or as_diff):
        write_out(change.new or b"")
        return OK
    changes = [change] if change.new != data else []
    _print(changes, as_diff)
    return NO if changes else OK


@dataclass(frozen=True, slots=True)
class _Form:
    """How files are formatted."""

    options: Options
    encoding: str
    lines: tuple[int, int] | None

    def change(self, path: Path, data: bytes) -> Change:
        """Return a file with its formatted content. Raises InputError."""
        new = format_bytes(
            data,
            path.as_posix(),
            self.options,
            encoding=self.encoding,
            lines=self.lines,
        )
        return Change(path, data, new)


def _files(project: Project, paths: tuple[str, ...]) -> Iterator[Path]:
    """Yield the files to format. Raises InputError for a file that cannot be formatted."""
    if not paths and project.file is None:
        raise click.UsageError("no rtgen.toml here or in a folder above: name a PATH")
    named = [Path(path) for path in paths] or project.sources
    # The output folder of a project is rtgen's own.
    is_output = cache(lambda folder: (folder / MANIFEST).is_file())
    for path in files_below(named, skip=project.output):
        if path in named and paths:
            check_name(path.as_posix())
        elif any(map(is_output, path.absolute().parents)):
            continue
        if path.suffix.lower() in SUFFIXES:
            yield path


def _change(form: _Form, path: Path, *, is_named: bool) -> Change:
    """Return a file with its formatted content.

    Raises InputError, also for a file that is left as it is since its formatter is missing.
    """
    is_toml = path.suffix.lower() == toml.SUFFIX
    if is_toml and not is_named and not toml.is_available():
        message = f"{path.as_posix()} is left as it is: tombi is not installed"
        raise InputError([NO_FORMATTER.at(None, message, hint=installation("fmt"))])
    return form.change(path, _content(path))


def _content(path: Path) -> bytes:
    try:
        return read_file(path, MAX_BYTES)
    except UnreadableError as error:
        message = f"{path.as_posix()} cannot be read: {error}"
        raise InputError([OTHER_FILE.at(None, message)]) from error


def _print(changes: list[Change], as_diff: bool) -> None:
    if as_diff:
        from rtgen.tools.compiling.diffs import diff

        write_out(diff(changes))
    else:
        write_out("".join(f"{shown(change.path)}\n" for change in changes))
