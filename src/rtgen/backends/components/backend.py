"""The generated files of a model's components."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rtgen.backends import Artifact, Emission, Options, Owner
from rtgen.backends.components.base_module import base_module
from rtgen.backends.components.checks import check, check_modules, components_of
from rtgen.backends.components.locations import (
    components_folder,
    factory,
    package_folder,
    source_of,
)
from rtgen.backends.components.skeleton import skeleton_module
from rtgen.backends.kit.python_text import header_comment
from rtgen.backends.kit.rendering import render
from rtgen.diagnostics import has_errors
from rtgen.model import Component, Model, SourceFile
from rtgen.typemap.idl_python_names import PythonNames
from rtgen.typemap.python_names import module_name


@dataclass(frozen=True, slots=True)
class _Entry:
    """A factory of instances of the component type `name`."""

    name: str
    module: str
    factory: str


class ComponentsBackend:
    """Generates a package for each component, its skeleton, and the entry points."""

    name = "components"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all components; none where a component has errors."""
        found = [*check(model), *check_modules(model, options.skeleton_package)]
        components = components_of(model)
        if has_errors(found) or not components:
            return Emission((), found)
        names = PythonNames(model, options.package)
        artifacts = list(_common(model, components, options))
        for component in components:
            artifacts += _of_component(model, names, component, options)
        return Emission(artifacts, found)


BACKEND = ComponentsBackend()


def _common(
    model: Model, components: Sequence[Component], options: Options
) -> Iterator[Artifact]:
    sources = list(
        dict.fromkeys(source_of(model, component) for component in components)
    )
    origin = tuple(source.key for source in sources)
    header = _header(options, sources)
    folder = components_folder(options)
    package = render("components/components.py.j2", header=header)
    yield Artifact(f"{folder}/__init__.py", package, origin)
    ordered = sorted(components, key=lambda component: component.name[-1])
    entries = [_entry(component, options) for component in ordered]
    text = render("components/entry_points.txt.j2", header=header, entries=entries)
    yield Artifact(f"{folder}/entry_points.txt", text, origin)


def _of_component(
    model: Model, names: PythonNames, component: Component, options: Options
) -> Iterator[Artifact]:
    origin = (source_of(model, component).key,)
    base = base_module(model, names, component, options)
    yield Artifact(f"{package_folder(options, component)}/__init__.py", base, origin)
    if not component.factory:
        skeleton = skeleton_module(model, names, component, options)
        module = module_name(component.name[-1])
        yield Artifact(f"{module}.py", skeleton, origin, Owner.USER)


def _header(options: Options, sources: Sequence[SourceFile]) -> str:
    return header_comment(options.version, (source.key for source in sources))


def _entry(component: Component, options: Options) -> _Entry:
    return _Entry(component.name[-1], *factory(component, options))
