"""The generated files of a model's components."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.backends import Artifact, Emission, Options, Owner, Part, parts
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
from rtgen.backends.kit.quoting.properties import language_entry
from rtgen.backends.kit.rendering import render
from rtgen.diagnostics import Diagnostic, has_errors
from rtgen.model import Component, Model
from rtgen.typemap.idl_python_names import PythonNames
from rtgen.typemap.python_names import module_name


class ComponentsBackend:
    """Generates a package for each component, its skeleton, and the entry points."""

    name = "components"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all components; none where a component has errors."""
        packages = list(parts(model, options))
        found: list[Diagnostic] = []
        for part in packages:
            found += check(part.model)
            found += check_modules(part.model, options.skeleton_package)
        if has_errors(found):
            return Emission((), found)
        artifacts: dict[str, Artifact] = {}
        for part in packages:
            for artifact in _of_part(part):
                # Boards with a signature of one name share the skeleton of its client.
                artifacts.setdefault(artifact.path, artifact)
        return Emission([*artifacts.values(), *_entry_points(packages)], found)


BACKEND = ComponentsBackend()


def _of_part(part: Part) -> Iterator[Artifact]:
    """The packages of a part's own components, with the folder they are in, and skeletons."""
    components = components_of(part.own)
    if not components:
        return
    header, origin = _header(part, components)
    package = render("components/components.py.j2", header=header)
    yield Artifact(f"{components_folder(part.options)}/__init__.py", package, origin)
    names = PythonNames(part.model, part.options.package)
    for component in components:
        yield from _of_component(part, names, component)


def _of_component(
    part: Part, names: PythonNames, component: Component
) -> Iterator[Artifact]:
    model, options = part.model, part.options
    origin = part.origin or (source_of(model, component).key,)
    base = base_module(model, names, component, options)
    yield Artifact(f"{package_folder(options, component)}/__init__.py", base, origin)
    if not component.factory:
        skeleton = skeleton_module(model, names, component, options)
        module = module_name(component.name[-1])
        yield Artifact(f"{module}.py", skeleton, origin, Owner.USER)


def _entry_points(packages: Sequence[Part]) -> Iterator[Artifact]:
    """The factories of all component types, in the project's package.

    Of two types of one name, that of the first part is listed.
    """
    entries: dict[str, str] = {}
    foreign: dict[str, str] = {}
    origin: dict[str, None] = {}
    for part in packages:
        components = components_of(part.model)
        origin |= dict.fromkeys(_header(part, components)[1])
        for component in components:
            target = ":".join(factory(component, part.options))
            entries.setdefault(component.name[-1], target)
            if component.is_foreign:
                foreign[component.name[-1]] = language_entry(component.language)
    options = packages[0].options
    if entries:
        text = render(
            "components/entry_points.txt.j2",
            header=header_comment(options.version, origin),
            entries=sorted(entries.items()),
            foreign=sorted(foreign.items()),
        )
        path = f"{components_folder(options)}/entry_points.txt"
        yield Artifact(path, text, tuple(origin))


def _header(part: Part, components: Sequence[Component]) -> tuple[str, tuple[str, ...]]:
    """The comment above what is made of components, and its origin."""
    origin = part.origin or tuple(
        dict.fromkeys(source_of(part.model, component).key for component in components)
    )
    return header_comment(part.options.version, origin), origin
