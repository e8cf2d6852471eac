"""Reads and validates the systems among a project's sources, with the `.conf` files beside them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends import Dependency, FrontendResult, key_of
from rtgen.compiler.frontends.profiles import profile_tree, rts_profile
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Model, System, SystemComponent
from rtgen.compiler.model.system_links import definitions_of, known_components
from rtgen.compiler.systems import ros_topics
from rtgen.compiler.systems.checks import check, check_properties, conf_sources
from rtgen.compiler.typemap.openrtm_ports import ports_of, with_definition_names
from rtgen.facts.encodings import decode, digest
from rtgen.facts.files import read_start

_MAX_CONF_BYTES = 1024 * 1024


@dataclass(slots=True)
class Systems:
    """Result of reading; fields as in `frontends.FrontendResult`."""

    systems: list[System] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    sources: dict[str, str] = field(default_factory=dict)
    dependencies: list[Dependency] = field(default_factory=list)


def read(
    paths: Sequence[Path], *, root: Path, output: Path, encoding: str = "auto"
) -> Systems:
    """Read systems, each with `<Type>.conf` and `<Instance>.conf` of its folder.

    `output` is the output folder of the project, `encoding` that of files that are not UTF-8.
    """
    systems = Systems()
    for path in paths:
        file = path.as_posix()
        stages.file(file)
        data = profile_tree.read(path, file, systems.diagnostics.append)
        if data is None:
            systems.dependencies.append(Dependency(path, None))
            continue
        systems.dependencies.append(Dependency(path, sha256(data).hexdigest()))
        result = rts_profile.load_bytes(data, file, encoding)
        systems.diagnostics += result.diagnostics
        systems.sources |= result.sources
        if result.system is not None:
            system = _with_conf(
                result.system, path.parent, systems.dependencies, encoding
            )
            systems.sources |= conf_sources(system)
            systems.systems.append(
                replace(
                    system,
                    key=key_of(path, root),
                    sha256=digest(data),
                    folder=_relative_folder(output, path.parent),
                )
            )
    return systems


def _relative_folder(start: Path, folder: Path) -> str:
    """Return the relative path of a folder; empty on another drive."""
    try:
        return Path(os.path.relpath(folder, start)).as_posix()
    except ValueError:
        return ""


def read_file(
    path: Path, encoding: str = "auto"
) -> tuple[System | None, Sequence[Diagnostic], Mapping[str, str]]:
    """Read an RtsProfile, with the `.conf` files of its folder.

    Return the system (None if it has errors), the diagnostics, and the sources.
    """
    result = rts_profile.load(path, display=path.as_posix(), encoding=encoding)
    system, sources = result.system, result.sources
    if system is not None:
        system = _with_conf(system, path.parent, [], encoding)
        sources = {**sources, **conf_sources(system)}
    return system, result.diagnostics, sources


def added(
    result: FrontendResult,
    paths: Sequence[Path],
    *,
    root: Path,
    output: Path,
    encoding: str = "auto",
    topics: Sequence[ros_topics.TopicEntry] = (),
) -> FrontendResult:
    """Return the result with systems, validated against its definitions; see `read`.

    `topics` are those of `[ros2.topics]`.
    """
    with stages.stage("systems"):
        systems = read(paths, root=root, output=output, encoding=encoding)
        named, diagnostics = against(systems.systems, result, topics)
    return replace(
        result,
        model=replace(result.model, systems=tuple(named)),
        diagnostics=(*result.diagnostics, *systems.diagnostics, *diagnostics),
        sources={**result.sources, **systems.sources},
        dependencies=(*result.dependencies, *systems.dependencies),
    )


def against(
    systems: Sequence[System],
    definitions: FrontendResult,
    topics: Sequence[ros_topics.TopicEntry] = (),
) -> tuple[Sequence[System], list[Diagnostic]]:
    """Return the systems with the definitions' port names, and their diagnostics."""
    if has_errors(definitions.diagnostics):
        diagnostics = [d for each in systems for d in check_properties(each)]
        return systems, diagnostics
    models = models_of(definitions)
    named = as_defined(systems, models)
    return named, list(checked(named, models, topics))


def models_of(definitions: FrontendResult) -> Sequence[Model]:
    """Return the models in definitions that have components; none if there are errors."""
    if has_errors(definitions.diagnostics):
        return ()
    model = definitions.model
    return [model, *(package.model for package in model.packages)]


def as_defined(systems: Iterable[System], models: Iterable[Model]) -> list[System]:
    """Return the systems with the definitions' port names in place of OpenRTM's."""
    components = known_components(models)
    return [
        with_definition_names(
            system,
            {
                c.instance: ports_of(components[c.type].component)
                for c in system.components
                if c.type in components
            },
        )
        for system in systems
    ]


def checked(
    systems: Iterable[System],
    models: Iterable[Model],
    topics: Sequence[ros_topics.TopicEntry] = (),
) -> Iterator[Diagnostic]:
    """Yield diagnostics about systems whose components are defined in models."""
    components = known_components(models)
    for system in systems:
        yield from check(system, components)
        yield from ros_topics.findings(topics, definitions_of(system, components))


def _with_conf(
    system: System, folder: Path, dependencies: list[Dependency], encoding: str
) -> System:
    components = [
        replace(c, conf_files=tuple(_conf_files(c, folder, dependencies, encoding)))
        for c in system.components
    ]
    return replace(system, components=tuple(components))


def _conf_files(
    c: SystemComponent, folder: Path, dependencies: list[Dependency], encoding: str
) -> Iterator[tuple[str, str]]:
    for name in dict.fromkeys((c.type, c.instance)):
        path = folder / f"{name}.conf"
        if path.parent != folder:
            continue
        try:
            data = read_start(path, _MAX_CONF_BYTES)
        except OSError:
            dependencies.append(Dependency(path, None))
            continue
        dependencies.append(Dependency(path, sha256(data).hexdigest()))
        yield path.name, decode(data, encoding, standard=True).normal
