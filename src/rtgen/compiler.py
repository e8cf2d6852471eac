"""The compiler: from a project through front ends, lowerings and back ends; writes no files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

from rtgen import __version__, plugins
from rtgen.backends import Artifact, Backend, Options
from rtgen.diagnostics import Diagnostic, has_errors, in_order

if TYPE_CHECKING:
    from rtgen.frontends import FrontendResult
    from rtgen.frontends.rtc_profile import Profiles
    from rtgen.model import Model, System
    from rtgen.project import Project
    from rtgen.project.cache import Cache

BUILT_IN = (
    "rtgen.backends.types",
    "rtgen.backends.components",
    "rtgen.backends.rtc_profile",
    "rtgen.backends.tecs",
    "rtgen.backends.canopen",
    "rtgen.backends.adapters",
    "rtgen.backends.openrtm",
    "rtgen.backends.small",
)
"""The modules of the built-in back ends, in the order of their artifacts; each has `BACKEND`."""


@dataclass(frozen=True, slots=True)
class Compilation:
    """The result of a run: artifacts (none if there are errors), and their inputs.

    `inputs` maps the key of each file read to its sha256; `dependencies` maps the path of each
    file looked for to its sha256, or to None where it was missing. `sources` are the texts of
    the files that diagnostics refer to, by their displayed paths.
    """

    artifacts: tuple[Artifact, ...]
    inputs: Mapping[str, str]
    diagnostics: tuple[Diagnostic, ...]
    dependencies: Mapping[str, str | None]
    sources: Mapping[str, str] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether the input has errors."""
        return has_errors(self.diagnostics)


def read(
    project: Project, *, lowered: bool = False, adopted: Profiles | None = None
) -> FrontendResult:
    """The model of the project's definitions; `lowered`: with the IDL and components of devices.

    `adopted` are profiles that the caller has read, which replace the project's own and
    components of their names.
    """
    from rtgen.frontends import together

    of_tecs = _ending_with(project.sources, ".cdl", ".cde")
    of_devices = _ending_with(project.sources, ".eds", ".dcf")
    of_idl = _ending_with(project.sources, ".idl")
    of_buses = _ending_with(project.sources, ".toml")
    of_profiles = _ending_with(project.sources, ".xml", ".yaml", ".yml")
    results: list[FrontendResult] = []
    side = None
    profiles = None
    if adopted is not None:
        from rtgen import component_profiles

        needed = component_profiles.needed(adopted, of_idl)
        profiles = replace(needed, given=frozenset())
    elif of_profiles:
        from rtgen import component_profiles

        root, include = project.root, project.include
        profiles = component_profiles.read(
            of_profiles, of_idl, root=root, include=include
        )
    if profiles is not None:
        of_idl += profiles.paths
    if of_devices or of_buses:
        from rtgen import devices

        described = devices.read(of_devices, of_buses, project)
        results.append(described)
        if of_idl or lowered:
            side = devices.device_idl(described, of_idl, given=lowered)
    if of_idl or side is not None or profiles or not (of_tecs or results):
        from rtgen.frontends import idl
        from rtgen.standard_idl import dependencies, standard_idl

        found = idl.load(
            of_idl,
            root=project.root,
            include=project.include,
            define=dict(project.define),
            ignore_case_clashes=project.ignore_case_clashes,
            virtual={
                **(standard_idl(of_idl) if profiles is None else profiles.virtual),
                **({} if side is None else side.files),
            },
        )
        found = replace(
            found, dependencies=(*found.dependencies, *dependencies(found.model))
        )
        if side is not None:
            found = replace(
                found,
                model=side.complete(found.model),
                diagnostics=(*found.diagnostics, *side.diagnostics),
                dependencies=(*found.dependencies, *side.dependencies),
            )
        results = [*(profiles.results(found) if profiles else [found]), *results]
    if of_tecs:
        from rtgen.frontends import cdl

        results.append(
            cdl.load(
                of_tecs,
                root=project.root,
                include=(*project.include, *project.tecs_path),
                define=dict(project.define),
                kcode=project.kcode,
                prelude=project.prelude == "kernel",
            )
        )
    results += _read_by_plugins(project)
    result = results[0] if len(results) == 1 else together(results)
    if has_errors(result.diagnostics):
        return result
    from rtgen.lowering import stage

    lowerings = stage.LOWERINGS if lowered else stage.DEFINITIONS
    made = stage.lowered(result.model, project.lowering, lowerings)
    return replace(
        result,
        model=made.model,
        diagnostics=(*result.diagnostics, *made.diagnostics),
    )


def _read_by_plugins(project: Project) -> Iterator[FrontendResult]:
    """The results of plug-ins' front ends for the project's files."""
    for name, frontend in plugins.loaded(plugins.Group.FRONTENDS):
        paths = _ending_with(project.sources, *frontend.suffixes)
        if paths:
            yield frontend.load(
                paths,
                root=project.root,
                include=project.include,
                options=project.plugins.get(name, {}),
            )


def _ending_with(paths: Sequence[Path], *suffixes: str) -> list[Path]:
    return [path for path in paths if path.suffix.lower() in suffixes]


def read_system(
    path: Path,
) -> tuple[System | None, Sequence[Diagnostic], Mapping[str, str]]:
    """The system of an RtsProfile (None if it has errors), the diagnostics, and the sources."""
    from rtgen.frontends import rts_profile

    return rts_profile.load(path, display=path.as_posix())


def build(project: Project, cache: Cache | None) -> Compilation:
    """The project's artifacts: from the cache unless one of their inputs has changed."""
    if cache is None:
        return compile_project(project)
    key = cache.key(project, plugins.announced(*plugins.Group))
    return _kept(cache, key, lambda: compile_project(project))


def inspect(
    project: Project | None,
    profiles: Sequence[Path],
    cache: Cache | None,
    *,
    as_json: bool,
) -> Compilation:
    """The model of a project's definitions and of system profiles as text: one artifact.

    The result is cached as that of `build`, unless there are profiles.
    """
    if cache is None or project is None or profiles:
        return _inspected(project, profiles, as_json)
    key = cache.key(
        project,
        plugins.announced(plugins.Group.FRONTENDS),
        made="json" if as_json else "text",
    )
    return _kept(cache, key, lambda: _inspected(project, (), as_json))


def _kept(cache: Cache, key: str, make: Callable[[], Compilation]) -> Compilation:
    found = cache.load(key)
    if found is None:
        found = make()
        if not found.failed:
            cache.store(key, found)
    return found


def _inspected(
    project: Project | None, profiles: Sequence[Path], as_json: bool
) -> Compilation:
    from rtgen.frontends import FrontendResult
    from rtgen.inspection.models import json_text, tree
    from rtgen.model import Model

    nothing = FrontendResult(Model(), (), {}, ())
    result = nothing if project is None else read(project)
    systems: list[System] = []
    diagnostics = list(result.diagnostics)
    sources = dict(result.sources)
    for profile in profiles:
        system, found, texts = read_system(profile)
        diagnostics += found
        sources |= texts
        if system is not None:
            named, seen = _looked_at(system, project)
            systems += named
            diagnostics += seen
    model = replace(result.model, systems=tuple(systems))
    diagnostics = in_order(diagnostics)
    text = json_text(model, diagnostics) if as_json else tree(model)
    return Compilation(
        artifacts=(Artifact("model", text, ()),),
        inputs={},
        diagnostics=tuple(diagnostics),
        dependencies=_hashes(result),
        sources=sources,
    )


def _looked_at(
    system: System, project: Project | None
) -> tuple[Sequence[System], Sequence[Diagnostic]]:
    """See `_checked`; without a project only checks that need no definitions are made."""
    from rtgen.systems import checks as system_checks

    if project is None:
        found = system_checks.check_properties(system)
        return [system], system_checks.as_warnings(found)
    return _checked([system], read(project, lowered=True), _options(project))


def _checked(
    profiles: Sequence[System], definitions: FrontendResult, options: Options
) -> tuple[Sequence[System], list[Diagnostic]]:
    """The systems with the definitions' names of ports, and their diagnostics.

    If the definitions have errors, only properties are checked.
    """
    from rtgen.systems import checks as system_checks
    from rtgen.systems import reading as systems

    if has_errors(definitions.diagnostics):
        found = [d for each in profiles for d in system_checks.check_properties(each)]
        return profiles, found
    models = component_models(definitions.model)
    named = systems.as_defined(profiles, models)
    return named, list(systems.checked(named, models))


def _hashes(result: FrontendResult) -> dict[str, str | None]:
    return {str(d.path.absolute()): d.sha256 for d in result.dependencies}


def compile_project(project: Project) -> Compilation:
    """The project's artifacts, compiled without the cache."""
    result = read(project, lowered=True)
    options = _options(project)
    result = _with_systems(result, project, options)
    diagnostics = list(result.diagnostics)
    artifacts: list[Artifact] = []
    if not has_errors(diagnostics):
        for backend in backends():
            emission = backend.emit(result.model, options)
            artifacts += emission.artifacts
            diagnostics += emission.diagnostics
    return Compilation(
        artifacts=() if has_errors(diagnostics) else tuple(artifacts),
        inputs={file.key: file.sha256 for file in result.model.files}
        | {device.key: device.sha256 for device in result.model.devices}
        | {bus.key: bus.sha256 for bus in result.model.buses}
        | {system.key: system.sha256 for system in result.model.systems},
        diagnostics=tuple(in_order(diagnostics)),
        dependencies=_hashes(result),
        sources=result.sources,
    )


def _options(project: Project) -> Options:
    return Options(
        package=project.package,
        skeleton_package=project.skeleton_package,
        version=__version__,
        target=project.target,
        small=project.small,
        representation=project.representation,
        extensibility=project.extensibility,
        tecs_corba=project.tecs_corba,
        factories=dict(project.components),
        skeleton_path=project.skeleton_path,
        plugins=project.plugins,
    )


def _with_systems(
    result: FrontendResult, project: Project, options: Options
) -> FrontendResult:
    """The result with the project's systems, if the target generates them."""
    from rtgen.project import SYSTEMS_TARGET

    if not project.systems or project.target != SYSTEMS_TARGET:
        return result
    from rtgen.systems import reading as systems

    found = systems.read(project.systems, root=project.root, output=project.output)
    named, checked = _checked(found.systems, result, options)
    return replace(
        result,
        model=replace(result.model, systems=tuple(named)),
        diagnostics=(*result.diagnostics, *found.diagnostics, *checked),
        sources={**result.sources, **found.sources},
        dependencies=(*result.dependencies, *found.dependencies),
    )


def component_models(model: Model) -> list[Model]:
    """The models with the components of a project: its own, and those of its packages."""
    return [model, *(package.model for package in model.packages)]


def backends() -> Iterator[Backend]:
    """The built-in back ends, then those of plug-ins; ToolError for a broken plug-in."""
    for module in BUILT_IN:
        yield cast("Backend", import_module(module).BACKEND)
    for _, backend in plugins.loaded(plugins.Group.BACKENDS):
        yield cast("Backend", backend)
