"""The compiler: front ends by suffix, then lowerings, then back ends; writes no files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from msgspec.structs import replace

from rtgen import stages
from rtgen.backends import Emission, Options
from rtgen.backends import stage as backends
from rtgen.diagnostics import has_errors, in_order
from rtgen.facts.ros import INTERFACE_SUFFIXES
from rtgen.frontends import FrontendResult, together
from rtgen.frontends import stage as frontends
from rtgen.frontends.kit.memo import Memo
from rtgen.lowering import stage as lowering
from rtgen.model import Model
from rtgen.project import Project
from rtgen.project.compilation import Compilation
from rtgen.resources import ros_file, ros_interfaces


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
    others = together([*also, *frontends.read(project.sources, settings)])
    of_idl = frontends.read_idl(
        project.sources,
        settings,
        named=others.idl,
        needed=lowering.needed_idl(others.model, complete=lowered),
        printed=printed_idl(others.model),
    )
    result = _merged(of_idl, others)
    if has_errors(result.diagnostics):
        return result
    made = lowering.lowered(result.model, project.lowering, complete=lowered)
    diagnostics = (*result.diagnostics, *made.diagnostics)
    return replace(result, model=made.model, diagnostics=diagnostics)


def printed_idl(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of IDL files that can be included but are on no disk, by name.

    They are printed from definitions in other languages, and from the ROS 2 interfaces that ship
    with rtgen.
    """
    shipped = {
        f"{name.rpartition('.')[0]}.idl": partial(_idl_of_shipped, name)
        for name in ros_interfaces()
    }
    return {**shipped, **backends.printed_idl(model)}


def _idl_of_shipped(name: str) -> str:
    from rtgen.backends import ros_idl
    from rtgen.frontends import rosidl

    file = ros_file(name)
    model = rosidl.load([file], root=file.parents[2]).model
    return ros_idl.idl_of(model, f"{name.rpartition('.')[0]}.idl")


def _merged(of_idl: FrontendResult, others: FrontendResult) -> FrontendResult:
    """Merge all definitions. A ROS 2 interface that was read replaces the IDL printed from it."""
    if not any(file.name.endswith(INTERFACE_SUFFIXES) for file in others.model.files):
        return together([of_idl, others])
    from rtgen.backends.ros_idl import idl_names

    names = idl_names(others.model)
    model = of_idl.model
    files = tuple(
        replace(file, includes=tuple(names.get(each, each) for each in file.includes))
        for file in model.files
        if file.name not in names
    )
    kept = tuple(d for d in model.declarations if d.file not in names)
    rest = replace(of_idl, model=replace(model, files=files, declarations=kept))
    return together([others, rest])


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
        from rtgen.systems import reading

        result = reading.added(
            result, project.emitted_systems, root=project.root, output=project.output
        )
    made = Emission()
    if not has_errors(result.diagnostics):
        made = backends.together(_emissions(result.model, project.options))
    diagnostics = [*result.diagnostics, *made.diagnostics]
    model = result.model
    return Compilation(
        artifacts=() if has_errors(diagnostics) else tuple(made.artifacts),
        inputs={file.key: file.sha256 for file in model.files}
        | {device.key: device.sha256 for device in model.devices}
        | {bus.key: bus.sha256 for bus in model.buses}
        | {system.key: system.sha256 for system in model.systems},
        diagnostics=tuple(in_order(diagnostics)),
        dependencies=result.hashes,
        sources=result.sources,
        components=made.components,
    )


def _emissions(model: Model, options: Options) -> Iterator[Emission]:
    for backend in backends.backends():
        with stages.stage(f"back end {backend.name}"):
            emission = backend.emit(model, options)
            for artifact in emission.artifacts:
                stages.file(artifact.path)
        yield emission
