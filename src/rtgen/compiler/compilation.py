"""The compiler: front ends by suffix, then lowerings, then back ends; writes no files."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler import printed_idl
from rtgen.compiler.backends import Emission
from rtgen.compiler.backends import stage as backends
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import FrontendResult, together
from rtgen.compiler.frontends import stage as frontends
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.frontends.kit.places import place_of
from rtgen.compiler.lowering import stage as lowering
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project
from rtgen.compiler.project.compilation import Compilation, compilation_of
from rtgen.compiler.project.paths import shown_path


def read(
    project: Project,
    *,
    lowered: bool = False,
    also: Sequence[FrontendResult] = (),
    observer: frontends.Observer | None = None,
    memo: Memo | None = None,
) -> FrontendResult:
    """Return the model of the project's definitions, and diagnostics.

    `lowered`: after all lowerings, as back ends expect it; else only after those whose results
    count as definitions. `also` are results of other readers, for the same model. `observer` is
    given the names of the definitions. `memo` caches the results of earlier runs.
    """
    settings = replace(project.reading, observer=observer, memo=memo)
    doubts = FrontendResult(Model(), project.problems, {}, ())
    others = together([doubts, *also, *frontends.read(project.sources, settings)])
    of_idl = frontends.read_idl(
        project.sources,
        settings,
        named=others.idl,
        needed=lowering.needed_idl(others.model, complete=lowered),
        printed=printed_idl.printed_idl(others.model),
        interfaces=printed_idl.interfaces(settings, project.sources),
    )
    result = printed_idl.merged(of_idl, others)
    if has_errors(result.diagnostics):
        return result
    lowered_model = lowering.lowered(result.model, project.lowering, complete=lowered)
    diagnostics = (*result.diagnostics, *lowered_model.diagnostics)
    return replace(result, model=lowered_model.model, diagnostics=diagnostics)


def compile_project(project: Project) -> Compilation:
    """Return the artifacts of the project's definitions, and of its systems if its target has
    any.
    """
    return emitted(project, read(project, lowered=True))


def emitted(project: Project, result: FrontendResult) -> Compilation:
    """Return the artifacts of a project whose definitions are read and lowered, and of its
    systems.
    """
    if project.emitted_systems:
        from rtgen.compiler.systems import reading

        result = reading.added(
            result,
            project.emitted_systems,
            root=project.root,
            output=project.output,
            encoding=project.encoding,
        )
    if has_errors(result.diagnostics):
        return compilation_of(result, Emission())
    if project.templates:
        return _emitted_by_templates(project, result)
    return compilation_of(result, _emission(project, result))


def _emission(project: Project, result: FrontendResult) -> Emission:
    places = partial(place_of, result.sources)
    return backends.emitted(result.model, project.options, locate=places)


def _emitted_by_templates(project: Project, result: FrontendResult) -> Compilation:
    """Return the artifacts of a project with templates of its own, which are inputs, too."""
    from rtgen.compiler.backends.kit import project_templates

    templates = project_templates.read(project.templates)
    emission = Emission(diagnostics=templates.findings)
    if not templates.failed:
        with project_templates.laid_over(templates):
            emission = _emission(project, result)
    run = compilation_of(result, emission)
    digests = {
        shown_path(Path(path), project.root)
        .as_posix(): sha256(text.encode())
        .hexdigest()
        for path, text in templates.sources.items()
    }
    return replace(
        run,
        inputs={**run.inputs, **digests},
        sources={**run.sources, **templates.sources},
    )
