"""Runs the compiler, or takes the result from the cache if its inputs are unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen.compiler.kit import plugins, stages
from rtgen.compiler.project import Project
from rtgen.compiler.project.cache import Cache, hash_of
from rtgen.compiler.project.compilation import Compilation

if TYPE_CHECKING:  # imported lazily: a run from the cache needs no model
    from rtgen.compiler.diagnostics import Diagnostic
    from rtgen.compiler.model import System


def build(project: Project, cache: Cache | None) -> Compilation:
    """Return the project's artifacts."""

    def made() -> Compilation:
        with stages.stage("import the compiler"):
            from rtgen.compiler.compilation import compile_project

        return compile_project(project)

    if cache is None:
        return made()
    with stages.stage("cache"):
        key = cache.key(project, plugins.announced(*plugins.Group))
    return cache.kept(key, made)


def timelines(project: Project, cache: Cache | None) -> Sequence[Diagnostic]:
    """Return the diagnostics of the timelines beside the systems of a project."""

    def made() -> Compilation:
        from rtgen.compiler.systems import timeline_checks

        diagnostics = timeline_checks.findings(project.systems, project.encoding)
        files = (f for s in project.systems for f in (s, s.parent / "timeline.toml"))
        return Compilation(
            artifacts=(),
            inputs={},
            diagnostics=tuple(diagnostics),
            dependencies={str(file): hash_of(file) for file in files},
        )

    if not project.systems:
        return ()
    if cache is None:
        return made().diagnostics
    return cache.kept(cache.key(project, (), "timelines"), made).diagnostics


def inspect(
    project: Project | None,
    profiles: Sequence[Path],
    cache: Cache | None,
    *,
    as_json: bool,
) -> Compilation:
    """Return the model of a project's definitions and of system profiles as text: one artifact.

    It is cached unless there are profiles.
    """
    if cache is None or project is None or profiles:
        return _inspected(project, profiles, as_json)
    with stages.stage("cache"):
        key = cache.key(
            project,
            plugins.announced(plugins.Group.FRONTENDS),
            result="json" if as_json else "text",
        )
    return cache.kept(key, lambda: _inspected(project, (), as_json))


def _inspected(
    project: Project | None, profiles: Sequence[Path], as_json: bool
) -> Compilation:
    from msgspec.structs import replace

    from rtgen.compiler import compilation
    from rtgen.compiler.backends import Artifact
    from rtgen.compiler.diagnostics import in_order
    from rtgen.compiler.frontends import together
    from rtgen.compiler.inspection.models import json_text, tree

    result = together(()) if project is None else compilation.read(project)
    systems: list[System] = []
    diagnostics = list(result.diagnostics)
    sources = dict(result.sources)
    for profile in profiles:
        from rtgen.compiler.systems.reading import read_file

        system, findings, texts = read_file(profile)
        diagnostics += findings
        sources |= texts
        if system is not None:
            named, seen = _checked(system, project)
            systems += named
            diagnostics += seen
    model = replace(result.model, systems=tuple(systems))
    diagnostics = in_order(diagnostics)
    with stages.stage("print"):
        text = json_text(model, diagnostics) if as_json else tree(model)
    return Compilation(
        artifacts=(Artifact("model", text, ()),),
        inputs={},
        diagnostics=tuple(diagnostics),
        dependencies=result.hashes,
        sources=sources,
    )


def _checked(
    system: System, project: Project | None
) -> tuple[Sequence[System], Sequence[Diagnostic]]:
    """Return the system with the definitions' port names; without a project, unchanged."""
    from rtgen.compiler import compilation
    from rtgen.compiler.systems import checks, reading

    if project is None:
        diagnostics = checks.check_properties(system)
        return [system], checks.as_warnings(diagnostics)
    return reading.against([system], compilation.read(project, lowered=True))
