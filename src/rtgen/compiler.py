"""The compiler: front ends by suffix, then lowerings, then back ends; writes no files."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from rtgen import stages
from rtgen.backends import Artifact
from rtgen.backends import stage as backends
from rtgen.diagnostics import has_errors, in_order
from rtgen.frontends import FrontendResult, together
from rtgen.frontends import stage as frontends
from rtgen.frontends.kit.memo import Memo
from rtgen.lowering import stage as lowering
from rtgen.project import Project
from rtgen.project.compilation import Compilation


def read(
    project: Project,
    *,
    lowered: bool = False,
    also: Sequence[FrontendResult] = (),
    observer: frontends.Observer | None = None,
    memo: Memo | None = None,
) -> FrontendResult:
    """The model of the project's definitions, and diagnostics.

    `lowered`: after all lowerings, as back ends take it; else after those whose results count as
    definitions. `also` are results of other readers, for the same model. `observer` is shown the
    names of the definitions. `memo` has what runs before have read.
    """
    settings = replace(project.reading, observer=observer, memo=memo)
    others = together([*also, *frontends.read(project.sources, settings)])
    of_idl = frontends.read_idl(
        project.sources,
        settings,
        named=others.idl,
        needed=lowering.needed_idl(others.model, complete=lowered),
        printed=backends.printed_idl(others.model),
    )
    result = together([of_idl, others])
    if has_errors(result.diagnostics):
        return result
    made = lowering.lowered(result.model, project.lowering, complete=lowered)
    diagnostics = (*result.diagnostics, *made.diagnostics)
    return replace(result, model=made.model, diagnostics=diagnostics)


def compile_project(project: Project) -> Compilation:
    """The artifacts of the project's definitions, and of its systems if the target has any."""
    return emitted(project, read(project, lowered=True))


def emitted(project: Project, result: FrontendResult) -> Compilation:
    """The artifacts of a project's definitions, which are read and lowered, and its systems."""
    if project.emitted_systems:
        from rtgen.systems import reading

        result = reading.added(
            result, project.emitted_systems, root=project.root, output=project.output
        )
    diagnostics = list(result.diagnostics)
    artifacts: list[Artifact] = []
    if not has_errors(diagnostics):
        for backend in backends.backends():
            with stages.stage(f"back end {backend.name}"):
                emission = backend.emit(result.model, project.options)
                for artifact in emission.artifacts:
                    stages.file(artifact.path)
            artifacts += emission.artifacts
            diagnostics += emission.diagnostics
    model = result.model
    return Compilation(
        artifacts=() if has_errors(diagnostics) else tuple(artifacts),
        inputs={file.key: file.sha256 for file in model.files}
        | {device.key: device.sha256 for device in model.devices}
        | {bus.key: bus.sha256 for bus in model.buses}
        | {system.key: system.sha256 for system in model.systems},
        diagnostics=tuple(in_order(diagnostics)),
        dependencies=result.hashes,
        sources=result.sources,
    )
