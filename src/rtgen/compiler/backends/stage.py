"""The back ends: the built-in ones, then those of plug-ins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rtgen.compiler.backends import (
    Artifact,
    Backend,
    ComponentTypes,
    DeferredBackend,
    Emission,
    Options,
    Owner,
)
from rtgen.compiler.backends.kit.quoting.code import UnquotableError
from rtgen.compiler.backends.kit.rules import UNQUOTABLE
from rtgen.compiler.diagnostics import Diagnostic, InputError, Span
from rtgen.compiler.kit import plugins, stages

if TYPE_CHECKING:
    from rtgen.compiler.model import Model


def _has_components(model: Model, _: Options) -> bool:
    from rtgen.compiler.model import Component

    models = (model, *(package.model for package in model.packages))
    return any(isinstance(each, Component) for m in models for each in m.declarations)


BUILT_IN: Final = (
    DeferredBackend(
        "types",
        "rtgen.compiler.backends.types.backend",
        lambda model, _: bool(model.declarations or model.packages),
    ),
    DeferredBackend(
        "components", "rtgen.compiler.backends.components.backend", _has_components
    ),
    DeferredBackend(
        "rtc-profile", "rtgen.compiler.backends.profiles.rtc_profile", _has_components
    ),
    DeferredBackend(
        "tecs",
        "rtgen.compiler.backends.tecs.backend",
        lambda model, _: bool(model.packages),
    ),
    DeferredBackend(
        "canopen",
        "rtgen.compiler.backends.canopen.backend",
        lambda model, _: bool(model.devices or model.buses),
    ),
    DeferredBackend(
        "adapters",
        "rtgen.compiler.backends.adapters",
        lambda model, _: bool(model.adapters),
    ),
    DeferredBackend(
        "ros-interfaces",
        "rtgen.ros2.backend.backend",
        lambda _, options: options.ros_interfaces,
    ),
    DeferredBackend(
        "ros-boards",
        "rtgen.ros2.boards.backend",
        lambda model, options: options.ros_boards is not None and bool(model.packages),
    ),
    DeferredBackend(
        "openrtm",
        "rtgen.openrtm.backend.backend",
        lambda _, options: options.target == "openrtm",
    ),
    DeferredBackend(
        "small",
        "rtgen.compiler.backends.small.backend",
        lambda _, options: options.target == "small",
    ),
    DeferredBackend(
        "typescript",
        "rtgen.compiler.backends.typescript.backend",
        lambda _, options: options.target == "typescript",
    ),
)
"""The built-in back ends, in the order of their artifacts, with predicates of their necessity."""


def backends() -> Iterator[Backend]:
    """Yield all back ends. Raises ToolError for a plug-in that cannot be imported."""
    yield from BUILT_IN
    for name, backend in plugins.loaded(plugins.Group.BACKENDS):
        with plugins.running(plugins.Group.BACKENDS, name):
            shown = plugins.require(str, backend.name)
        yield _PluginBackend(name, shown, backend)


class _PluginBackend(msgspec.Struct, frozen=True):
    """A back end of a plug-in, whose results are checked. Raises ToolError."""

    entry: str
    name: str
    backend: Any

    def emit(self, model: Model, options: Options) -> Emission:
        """Return its files."""
        group = plugins.Group.BACKENDS
        with plugins.running(group, self.entry, UnquotableError):
            emission = plugins.require(Emission, self.backend.emit(model, options))
            artifacts = plugins.require_each(Artifact, emission.artifacts)
            for each in artifacts:
                plugins.require(str, each.path)
                plugins.require(str, each.text)
                plugins.require(Owner, each.owner)
                plugins.require_each(str, each.origin)
            diagnostics = plugins.require_each(Diagnostic, emission.diagnostics)
            components = plugins.require(ComponentTypes, emission.components)
            return Emission(artifacts, diagnostics, components)


def emitted(
    model: Model,
    options: Options,
    chosen: Iterable[Backend] | None = None,
    locate: Callable[[str], Span | None] = lambda _: None,
) -> Emission:
    """Return what the back ends emit, by default all of them. Raises ToolError as `backends`.

    `locate` returns the place of a text in the definitions, for diagnostics about it.
    """
    return together(
        _emission(backend, model, options, locate) for backend in chosen or backends()
    )


def _emission(
    backend: Backend,
    model: Model,
    options: Options,
    locate: Callable[[str], Span | None],
) -> Emission:
    with stages.stage(f"back end {backend.name}"):
        try:
            emission = backend.emit(model, options)
        except InputError as error:
            return Emission(diagnostics=error.diagnostics)
        except UnquotableError as error:
            # The back end has no rule of its own for this text.
            message = f"back end {backend.name}: {error}"
            return Emission(diagnostics=[UNQUOTABLE.at(locate(error.text), message)])
        for artifact in emission.artifacts:
            stages.file(artifact.path)
    return emission


def together(emissions: Iterable[Emission]) -> Emission:
    """Return the combined results of several back ends, in their order.

    The parts of a Python module from several back ends become one file.
    """
    diagnostics: list[Diagnostic] = []
    components = ComponentTypes()
    files: list[list[Artifact]] = []
    by_name: dict[str, list[Artifact]] = {}
    for emission in emissions:
        diagnostics += emission.diagnostics
        components = components.joined(emission.components)
        own: dict[str, list[Artifact]] = {}
        for artifact in emission.artifacts:
            earlier = by_name.get(artifact.path)
            if earlier and _are_parts(*earlier, artifact):
                earlier.append(artifact)
                continue
            files.append([artifact])
            own.setdefault(artifact.path, files[-1])
        by_name = {**own, **by_name}
    diagnostics = list(
        dict.fromkeys(diagnostics)
    )  # several meet the same fault of a template
    return Emission(list(map(_composed, files)), diagnostics, components)


def _are_parts(*artifacts: Artifact) -> bool:
    """Return whether files with the same path are parts of a Python module."""
    from rtgen.compiler.backends.kit.python_module import PythonModule

    return all(isinstance(each, PythonModule) for each in artifacts)


def _composed(artifacts: list[Artifact]) -> Artifact:
    if len(artifacts) == 1:
        return artifacts[0]
    from rtgen.compiler.backends.kit.python_module import PythonModule, composed

    return composed([each for each in artifacts if isinstance(each, PythonModule)])


def printed_idl(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of IDL files that back ends print and definitions may include, by name."""
    printers: dict[str, Callable[[], str]] = {}
    if model.devices or model.buses:
        from rtgen.compiler.backends.canopen import idl_file

        printers |= idl_file.idl_files(model)
    return printers
