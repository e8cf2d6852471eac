"""The command `rtgen check`: compares generated files on disk with a fresh run."""

from __future__ import annotations

import click

from rtgen.cli.definition_options import (
    with_definitions,
    with_node_id,
    with_output,
    with_target,
)
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.project import behaviours, cache, shown
from rtgen.compiler.project import output as writer
from rtgen.tools.can.common import counted
from rtgen.tools.compiling.cached import build, timelines
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK


@click.command()
@with_definitions
@with_output("Compare with")
@with_node_id
@with_target
@with_console
@with_stages
def check(
    console: Console,
    definitions: Definitions,
    output: str | None,
    no_cache: bool,
    node_id: int | None,
    target: str | None,
) -> int:
    """Check that generated files are up to date.

    PATH is read as by generate. Exit code 0: up to date; 1: files are changed, missing, obsolete
    or not rtgen's, and a unified diff is printed, or a behaviour uses a component or a port that
    no definition has, or an event of the timeline.toml beside a system.xml names what the system
    does not have. Nothing is written.
    """
    project = project_of(
        definitions, output, add=output is None, node_id=node_id, target=target
    )
    runs = None if no_cache else cache.default()
    run = build(project, runs)
    console.findings(run.diagnostics, run.sources)
    if run.failed:
        return BAD_INPUT
    planned = writer.plan(project, run)
    of_timelines = timelines(project, runs)
    diagnostics = [*behaviours.check(project, run.artifacts), *of_timelines]
    console.findings(diagnostics)
    if has_errors(of_timelines):
        return BAD_INPUT
    strays = (*planned.strays, *planned.leftovers)
    apart = (change.without_line_ends() for change in planned.changes)
    changes = [change for change in apart if change is not None]
    where = shown(project.output)
    if converted := len(planned.changes) - len(changes):
        console.say(
            f"{where}: {counted(converted, 'file')} with other line ends, which do not"
            f" count; `{where}/** -text` in .gitattributes keeps git from converting them"
        )
    if not changes and not strays:
        return NO if diagnostics else OK
    from rtgen.tools.compiling.diffs import diff

    write_out(
        diff(changes) + "".join(f"Only in the tree: {shown(s)}\n" for s in strays)
    )
    stale = len(changes) + len(planned.leftovers)
    if stale:
        console.say(
            f"{where}: {counted(stale, 'file')} differ{'s' * (stale == 1)} from the"
            " definitions; run rtgen generate"
        )
    if planned.strays:
        console.say(
            f"{where}: {counted(len(planned.strays), 'file')} not made by rtgen, which"
            " generate leaves; move your files elsewhere, delete the rest"
        )
    return NO
