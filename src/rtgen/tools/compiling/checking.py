"""All that `rtgen check` finds, in parts; no code of the user is executed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from enum import StrEnum
from pathlib import Path

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity
from rtgen.compiler.kit import plugins, stages
from rtgen.compiler.project import Project, behaviours
from rtgen.compiler.project import output as writer
from rtgen.compiler.project.cache import Cache, hash_of
from rtgen.compiler.project.compilation import Compilation
from rtgen.compiler.systems.rules import TIMELINE_FILE, TOPIC_QOS
from rtgen.tools.compiling.cached import Definitions, build, of_behaviours


class Part(StrEnum):
    """What is checked, in the order of reporting."""

    DRIFT = "drift"
    SYSTEMS = "systems"
    TIMELINES = "timelines"
    UNITS = "units"
    BEHAVIOURS = "behaviours"
    LINT = "lint"


class Checked(msgspec.Struct, frozen=True):
    """The result of a check.

    `definitions` are the diagnostics of reading the definitions; with errors among them nothing
    else is checked. `sources` are texts that diagnostics refer to. `changes` are those of `planned`
    that are more than line ends, `converted` is the number of the others. `is_impossible`: the
    output folder cannot be generated, for the reasons found as drift.
    """

    definitions: Sequence[Diagnostic]
    findings: Mapping[Part, Sequence[Diagnostic]]
    sources: Mapping[str, str]
    planned: writer.Plan | None = None
    changes: Sequence[writer.Change] = ()
    converted: int = 0
    is_impossible: bool = False

    @property
    def loses(self) -> bool:
        """Whether a part of a device is lost when its description is read."""
        if not any(each.code.startswith("EDS") for each in self.definitions):
            return False
        from rtgen.compiler.frontends.eds.rules import LOSSES

        return any(each.code in LOSSES for each in self.definitions)


def checked(project: Project, runs: Cache | None, only: Collection[Part]) -> Checked:
    """Return the findings of the given parts. Raises ToolError."""
    definitions = Definitions(project)
    run = build(project, runs, definitions)
    if run.failed:
        return Checked(run.diagnostics, {}, run.sources)
    result = Checked(run.diagnostics, {}, run.sources)
    findings: dict[Part, Sequence[Diagnostic]] = {}
    if Part.DRIFT in only:
        result = _compared(project, run)
        findings.update(result.findings)
    others = [part for part in Part if part in only and part is not Part.DRIFT]
    sources = run.sources
    if others:
        judged = _judged(project, run, runs, definitions)
        sources = {**sources, **judged.sources}
        known = set(run.diagnostics)
        for part in others:
            findings[part] = [
                each
                for each in judged.diagnostics
                if part is _part(each, project) and each not in known
            ]
    return msgspec.structs.replace(result, findings=findings, sources=sources)


def _compared(project: Project, run: Compilation) -> Checked:
    """Return the comparison of the output folder with a run."""
    try:
        planned = writer.plan(project, run)
    except InputError as error:
        problems = {Part.DRIFT: error.diagnostics}
        return Checked(run.diagnostics, problems, run.sources, is_impossible=True)
    apart = [change.without_line_ends() for change in planned.changes]
    changes = [change for change in apart if change is not None]
    findings: Sequence[Diagnostic] = ()
    if changes or planned.strays or planned.leftovers:
        from rtgen.tools.compiling import drift

        findings = drift.findings(project, run, planned, changes)
    return Checked(
        run.diagnostics,
        {Part.DRIFT: findings},
        run.sources,
        planned,
        changes,
        len(apart) - len(changes),
    )


def _judged(
    project: Project, run: Compilation, runs: Cache | None, definitions: Definitions
) -> Compilation:
    """Return the diagnostics of all parts but drift, from the cache if nothing has changed."""
    modules = behaviours.modules(project, run.artifacts)

    def made() -> Compilation:
        return _made(project, definitions, of_behaviours(project, run, runs))

    if runs is None:
        return made()
    with stages.stage("cache"):
        also = [*map(str, project.systems), "", *map(str, modules)]
        also += [str(each) for each in (*project.lint, *project.ignored_in_files)]
        key = runs.key(project, plugins.announced(*plugins.Group), "findings", also)
    return runs.kept(key, made)


def _made(
    project: Project, definitions: Definitions, known: Compilation
) -> Compilation:
    from rtgen.compiler import linting
    from rtgen.compiler.systems import reading, timeline, timeline_checks

    read = definitions.read(lowered=True)
    systems = reading.added(
        read,
        project.systems,
        root=project.root,
        output=project.output,
        encoding=project.encoding,
        topics=project.ros2.topics,
    )
    diagnostics = [
        *systems.diagnostics,
        *timeline_checks.findings(
            project.systems,
            project.encoding,
            reading.models_of(read),
            behaviours.calls(project),
        ),
        *known.diagnostics,
    ]
    diagnostics += linting.of_check(project, definitions.read(lowered=False))
    findings = [d for d in diagnostics if d.severity is not Severity.NOTE]
    files: set[Path] = set()
    for path in project.systems:
        files.update(timeline.followed(path.parent / TIMELINE_FILE))
    hashes = {str(path.absolute()): hash_of(path) for path in files}
    return Compilation(
        artifacts=(),
        inputs={},
        diagnostics=tuple(linting.wanted(project, findings, systems.sources)),
        dependencies={**known.dependencies, **systems.hashes, **hashes},
        sources=systems.sources,
    )


def _part(finding: Diagnostic, project: Project) -> Part:
    """Return the part that a diagnostic belongs to."""
    from rtgen.compiler import linting
    from rtgen.compiler.systems.connection_rules import UNITS

    if finding.code in {*linting.UNIT_CODES, *(rule.code for rule in UNITS)}:
        return Part.UNITS
    if finding.code in {rule.code for rule in behaviours.RULES}:
        return Part.BEHAVIOURS
    file = finding.span.file if finding.span else ""
    is_topic = finding.code == TOPIC_QOS.code
    if is_topic or file in {path.as_posix() for path in project.systems}:
        return Part.SYSTEMS
    if Path(file).name == TIMELINE_FILE or finding.code.startswith("SYS"):
        return Part.TIMELINES
    return Part.LINT
