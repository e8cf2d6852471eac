"""The way of the data: from a project through front ends and back ends; writes nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

from rtgen import __version__
from rtgen.backends import Artifact, Backend, Options
from rtgen.diagnostics import Diagnostic, ToolError, has_errors, in_order

if TYPE_CHECKING:
    from importlib import metadata

    from rtgen.cache import Cache
    from rtgen.frontends import FrontendResult
    from rtgen.model import System
    from rtgen.project import Project

BUILT_IN = (
    "rtgen.backends.types",
    "rtgen.backends.components",
    "rtgen.backends.rtc_profile",
)
"""The modules of the built-in back ends, in the order of their artifacts; each has `BACKEND`."""

ENTRY_POINTS = "rtgen.backends"
"""The entry point group of plug-ins, which have the same interface."""


@dataclass(frozen=True, slots=True)
class Compilation:
    """What a run gives: artifacts (none if there are errors), and what they were made from.

    `inputs` maps the key of each file read to its sha256; `dependencies` maps the path of each
    file looked for to its sha256, or to None where it was missing. `sources` are the texts of
    the files that the findings speak of, by their displayed paths.
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


def read(project: Project) -> FrontendResult:
    """The model of the project's definitions."""
    from rtgen.frontends import idl

    return idl.load(
        project.sources,
        root=project.root,
        include=project.include,
        define=dict(project.define),
    )


def read_system(
    path: Path,
) -> tuple[System | None, Sequence[Diagnostic], Mapping[str, str]]:
    """The system of an RtsProfile (None if it has errors), the findings, and the texts read."""
    from rtgen.frontends import rts_profile

    return rts_profile.load(path, display=path.as_posix())


def build(project: Project, cache: Cache | None) -> Compilation:
    """The project's artifacts: from the cache, if nothing that they depend on has changed."""
    if cache is None:
        return compile_project(project)
    key = cache.key(project, plugins())
    found = cache.load(key)
    if found is None:
        found = compile_project(project)
        if not found.failed:
            cache.store(key, found)
    return found


def compile_project(project: Project) -> Compilation:
    """The project's artifacts, made anew."""
    result = read(project)
    options = Options(
        package=project.package,
        skeleton_package=project.skeleton_package,
        version=__version__,
        target=project.target,
    )
    diagnostics = list(result.diagnostics)
    artifacts: list[Artifact] = []
    if not has_errors(diagnostics):
        for backend in backends():
            emission = backend.emit(result.model, options)
            artifacts += emission.artifacts
            diagnostics += emission.diagnostics
    return Compilation(
        artifacts=() if has_errors(diagnostics) else tuple(artifacts),
        inputs={file.key: file.sha256 for file in result.model.files},
        diagnostics=tuple(in_order(diagnostics)),
        dependencies={str(d.path.absolute()): d.sha256 for d in result.dependencies},
        sources=result.sources,
    )


def plugins() -> tuple[metadata.EntryPoint, ...]:
    """The installed plug-ins, sorted by name."""
    from importlib import metadata

    return tuple(
        sorted(
            metadata.entry_points(group=ENTRY_POINTS), key=lambda e: (e.name, e.value)
        )
    )


def backends() -> Iterator[Backend]:
    """The built-in back ends, then those of plug-ins; ToolError for a broken plug-in."""
    for module in BUILT_IN:
        yield cast("Backend", import_module(module).BACKEND)
    for entry in plugins():
        try:
            yield cast("Backend", entry.load())
        except (ImportError, AttributeError) as error:
            raise ToolError(
                f"the back end {entry.name!r} ({entry.value}) cannot be loaded: {error}",
                hint="repair or uninstall the package that brings it",
            ) from error
