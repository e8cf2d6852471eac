"""One run of `rtgen generate`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import InputError, has_errors
from rtgen.compiler.kit import stages
from rtgen.compiler.project import Project, behaviours, cache, shown
from rtgen.compiler.project import output as writer
from rtgen.tools.compiling.cached import build, of_behaviours
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK


class Request(msgspec.Struct, frozen=True, kw_only=True):
    """The options of the command line."""

    definitions: Definitions
    output: str | None
    node_id: int | None
    target: str | None
    representation: str | None
    cached: bool
    only_diff: bool
    renames: tuple[tuple[str, str], ...] = ()

    def project(self) -> Project:
        """Return the project as it is now. Raises InputError, and ToolError for a target."""
        # The project's tree contains the output of all its sources, in every run.
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
        return project


def generate_once(console: Console, request: Request) -> tuple[int, Iterable[Path]]:
    """Return the exit code, and the paths of the files that the run searched for."""
    for old, new in request.renames:
        _rename(console, request, old, new)
    project = request.project()
    runs = cache.default() if request.cached else None
    run = build(project, runs)
    looked_for = map(Path, run.dependencies)
    if run.failed:
        console.findings(run.diagnostics, run.sources)
        return BAD_INPUT, looked_for
    awaited = behaviours.awaited(project, run.artifacts)
    if request.only_diff:
        from rtgen.tools.compiling.diffs import diff

        planned = writer.plan(project, run, awaited)
        write_out(diff((*planned.changes, *planned.skeletons)))
        console.findings(run.diagnostics, run.sources)
        return OK, looked_for
    # What has the base of before tells best what became of a component.
    of_users = of_behaviours(project, run, runs) if awaited else None
    done = writer.write(project, run, awaited)
    of_users = of_users or of_behaviours(project, run, runs)
    diagnostics = [*run.diagnostics, *of_users.diagnostics]
    console.findings(diagnostics, run.sources)
    console.say(_summary(project, done))
    if _lacks_build_scripts(project, done):
        console.say(
            "of a line through(RTCPlugin), build.bat and build.sh, and the profile of the "
            "marshaller, come with corba = true in [tecs] of rtgen.toml, or --target openrtm"
        )
    return BAD_INPUT if has_errors(of_users.diagnostics) else OK, looked_for


def generate_project(project: Project, runs: cache.Cache) -> None:
    """Write what a project's definitions make, without a word. Raises InputError, ToolError."""
    run = build(project, runs)
    if run.failed:
        raise InputError([d for d in run.diagnostics if has_errors([d])])
    writer.write(project, run, behaviours.awaited(project, run.artifacts))


def _lacks_build_scripts(project: Project, done: writer.Plan) -> bool:
    """Return whether the files of a board were written now, without those for CORBA."""
    if project.tecs_corba or project.target == "openrtm":
        return False
    return any(c.path.name == "RTCPlugin.rb" and c.new for c in done.changes)


def _rename(console: Console, request: Request, old: str, new: str) -> None:
    """Rename what definitions name, with all that follows. Raises InputError, ToolError."""
    from rtgen.tools.renaming import plan, writing

    with stages.stage("rename"):
        planned = plan.by_names(request.project, old, new)
        writing.write(planned)
    console.findings(planned.doubts)
    moves = "".join(f"; {shown(a)} is now {shown(b)}" for a, b in planned.moves)
    changed = len(planned.contents)
    console.say(
        f"{old} is now {planned.new}: {changed} file{'s' * (changed != 1)} changed{moves}"
    )


def _summary(project: Project, done: writer.Plan) -> str:
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
