"""`rtgen generate`."""

from __future__ import annotations

from dataclasses import replace

import click

from rtgen import cache, compiler
from rtgen import output as writer
from rtgen.cli.common import (
    BAD_INPUT,
    OK,
    Console,
    project_of,
    with_console,
    with_definitions,
    with_output,
    write_out,
)
from rtgen.diagnostics import ToolError
from rtgen.project import Project, shown


@click.command()
@with_definitions
@with_output
@click.option(
    "--target",
    type=click.Choice(["embedded", "openrtm", "dds"]),
    help="What the components run on; default: what rtgen.toml says, else embedded.",
)
@click.option(
    "--representation",
    type=click.Choice(["cdr", "xcdr2"]),
    help="What to_cdr gives where no annotation says it; default: what rtgen.toml says, else cdr.",
)
@click.option(
    "--diff", "only_diff", is_flag=True, help="Print what would change; write nothing."
)
@with_console
def generate(
    console: Console,
    paths: tuple[str, ...],
    include: tuple[str, ...],
    define: list[tuple[str, str]],
    ignore_case_clashes: bool,
    output: str | None,
    no_cache: bool,
    target: str | None,
    representation: str | None,
    only_diff: bool,
) -> int:
    """Make the files that the definitions ask for.

    PATH is a definition file or a folder of them. Without PATH the sources of rtgen.toml are
    read, which is looked for here and upwards. Files that rtgen owns are overwritten, and removed
    once nothing asks for them: the tree holds what this run's sources give, and no more. Skeletons
    are created once and then left alone.
    """
    project = project_of(paths, include, define, ignore_case_clashes, output)
    if target is not None:
        project = replace(project, target=target)
    if representation is not None:
        project = replace(project, representation=representation)
    if project.target != "embedded":
        raise ToolError(
            f"the target {project.target!r} is not available in this version",
            hint="the target 'embedded' is",
        )
    run = compiler.build(project, None if no_cache else cache.default())
    if run.failed:
        console.findings(run.diagnostics, run.sources)
        return BAD_INPUT
    if only_diff:
        from rtgen.cli.diffs import diff

        planned = writer.plan(project, run.artifacts, run.inputs)
        write_out(diff((*planned.changes, *planned.skeletons)))
        console.findings(run.diagnostics, run.sources)
        return OK
    done = writer.write(project, run.artifacts, run.inputs)
    console.findings(run.diagnostics, run.sources)
    console.say(_told(project, done))
    return OK


def _told(project: Project, done: writer.Plan) -> str:
    written = sum(c.new is not None for c in done.changes)
    removed = len(done.changes) - written
    text = f"{shown(project.output)}: {written} written, {removed} removed, {done.unchanged} same"
    if done.skeletons:
        text += (
            f"; skeletons created: {', '.join(shown(c.path) for c in done.skeletons)}"
        )
    if done.strays:
        text += f"; not rtgen's: {', '.join(map(shown, done.strays))}"
    return text
