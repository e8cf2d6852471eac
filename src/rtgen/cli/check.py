"""The command `rtgen check`: finds all that does not fit the definitions."""

from __future__ import annotations

import click

from rtgen.cli.definition_options import (
    with_definitions,
    with_node_id,
    with_output,
    with_target,
)
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.cli.stored_answers import with_answer
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.project import Project, cache, shown
from rtgen.compiler.project.output import MANIFEST
from rtgen.tools.can.common import counted
from rtgen.tools.compiling.checking import Checked, Part, checked
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console, write_out, write_text
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK

MAX_LINES = 24
"""Maximum number of lines of the diff of a file."""


@command()
@with_answer
@with_definitions
@with_output("Compare with")
@with_node_id
@with_target
@click.option(
    "--only",
    multiple=True,
    type=click.Choice([part.value for part in Part]),
    help="Check this part only; can be repeated.",
)
@with_console
@with_stages
def check(
    console: Console,
    definitions: Definitions,
    output: str | None,
    no_cache: bool,
    node_id: int | None,
    target: str | None,
    only: tuple[str, ...],
) -> int:
    """Check all that can be checked without a run.

    PATH is read as by generate, and may be a system. In this order: generated files that are not
    those of the definitions (drift), systems against the definitions, the timeline.toml beside a
    system.xml, units, also those of connected ports, behaviours against the definitions, and
    errors of lint.
    Exit code 0: nothing; 1: drift, warnings of the other parts, or a part of a device lost in its
    description; 2: errors. A finding about a generated file is at its definition, and its
    differences are printed.
    Nothing is written, and no behaviour is executed.
    """
    alone = output is not None
    project = project_of(
        definitions, output, not alone, node_id, target=target, judged=True
    )
    runs = None if no_cache else cache.default()
    result = checked(project, runs, [Part(name) for name in only] or [*Part])
    parts = [result.definitions, *(result.findings.get(part, ()) for part in Part)]
    for findings in parts:
        console.findings(findings, result.sources, summarised=False)
    _print_differences(console, project, result)
    console.summary([each for findings in parts for each in findings])
    return _exit_code(result)


def _exit_code(result: Checked) -> int:
    if has_errors(result.definitions):
        return BAD_INPUT
    others = (f for part, f in result.findings.items() if part is not Part.DRIFT)
    if result.is_impossible or any(map(has_errors, others)):
        return BAD_INPUT
    return NO if result.loses or any(result.findings.values()) else OK


def _print_differences(console: Console, project: Project, result: Checked) -> None:
    """Print the differences of generated files in a short form, and what to do."""
    if result.planned is None:
        return
    where = shown(project.output)
    if result.converted:
        console.say(
            f"{where}: {counted(result.converted, 'file')} with other line ends, which do"
            f" not count; `{where}/** -text` in .gitattributes keeps git from converting"
            " them"
        )
    strays = (*result.planned.strays, *result.planned.leftovers)
    if not result.changes and not strays:
        return
    from rtgen.tools.compiling.diffs import diff

    text = diff(result.changes, most=MAX_LINES)
    names = (printable(shown(path)) for path in strays)
    write_out(text)
    write_text("".join(f"Only in the tree: {name}\n" for name in names))
    manifest = project.output / MANIFEST
    files = [change for change in result.changes if change.path != manifest]
    stale = len(files or result.changes) + len(result.planned.leftovers)
    if stale:
        console.say(
            f"{where}: {counted(stale, 'file')} differ{'s' * (stale == 1)} from the"
            " definitions; run rtgen generate"
        )
    if result.planned.strays:
        console.say(
            f"{where}: {counted(len(result.planned.strays), 'file')} not made by rtgen,"
            " which generate leaves; move your files elsewhere, delete the rest"
        )
