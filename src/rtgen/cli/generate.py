"""`rtgen generate`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import click

from rtgen import behaviours, cache, compiler
from rtgen import output as writer
from rtgen.cli.common import (
    BAD_INPUT,
    OK,
    Console,
    Definitions,
    project_of,
    require_target,
    with_console,
    with_definitions,
    with_node_id,
    with_output,
    with_target,
    write_out,
)
from rtgen.project import Project, shown


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What the command line asks for."""

    definitions: Definitions
    output: str | None
    node_id: int | None
    target: str | None
    representation: str | None
    cached: bool
    only_diff: bool

    def project(self) -> Project:
        """The project as it is now. Raises InputError, and ToolError for a target."""
        # The tree of a project holds what all its sources give, in every run.
        alone = self.output is not None
        project = project_of(
            self.definitions,
            self.output,
            add=not alone,
            node_id=self.node_id,
            target=self.target,
        )
        if self.representation is not None:
            project = replace(project, representation=self.representation)
        require_target(project)
        return project


@click.command()
@with_definitions
@with_output
@with_node_id
@with_target
@click.option(
    "--representation",
    type=click.Choice(["cdr", "xcdr2"]),
    help="What to_cdr gives where no annotation says it; default: what rtgen.toml says, else cdr.",
)
@click.option(
    "--diff", "only_diff", is_flag=True, help="Print what would change; write nothing."
)
@click.option(
    "--watch", "watching", is_flag=True, help="Go on, and run again on every change."
)
@with_console
def generate(
    console: Console,
    definitions: Definitions,
    output: str | None,
    no_cache: bool,
    node_id: int | None,
    target: str | None,
    representation: str | None,
    only_diff: bool,
    watching: bool,
) -> int:
    """Make the files that the definitions ask for.

    PATH is a definition file or a folder of them. Without PATH the sources of rtgen.toml are
    read, which is looked for here and upwards. PATH is read beside them, so the tree stays whole;
    with -o alone. Files that rtgen owns are overwritten, and removed once nothing asks for them.
    Skeletons are created once and then left alone.
    """
    request = Request(
        definitions=definitions,
        output=output,
        node_id=node_id,
        target=target,
        representation=representation,
        cached=not no_cache,
        only_diff=only_diff,
    )
    if watching:
        from rtgen.cli.watch import watch

        return watch(console, request)
    return perform(console, request)[0]


def perform(console: Console, request: Request) -> tuple[int, Iterable[Path]]:
    """Carries it out once: the exit code, and the files that were looked for."""
    project = request.project()
    run = compiler.build(project, cache.default() if request.cached else None)
    looked_for = map(Path, run.dependencies)
    if run.failed:
        console.findings(run.diagnostics, run.sources)
        return BAD_INPUT, looked_for
    if request.only_diff:
        from rtgen.cli.diffs import diff

        planned = writer.plan(project, run.artifacts, run.inputs)
        write_out(diff((*planned.changes, *planned.skeletons)))
        console.findings(run.diagnostics, run.sources)
        return OK, looked_for
    done = writer.write(project, run.artifacts, run.inputs)
    found = [*run.diagnostics, *behaviours.check(project, run.artifacts)]
    console.findings(found, run.sources)
    console.say(_told(project, done))
    return OK, looked_for


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
