"""The generated files of a model's components."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from rtgen.compiler.backends import (
    Artifact,
    ComponentTypes,
    Emission,
    Options,
    Owner,
    Part,
    parts,
)
from rtgen.compiler.backends.components.base_module import base_module
from rtgen.compiler.backends.components.checks import (
    check,
    check_skeletons,
    components_of,
    own_components,
)
from rtgen.compiler.backends.components.locations import (
    components_folder,
    factory,
    skeleton_location,
    source_of,
)
from rtgen.compiler.backends.components.skeleton import skeleton_module
from rtgen.compiler.backends.kit.python_module import (
    PythonModule,
    composed,
    python_module,
)
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.model import Component, Model
from rtgen.compiler.typemap.python.idl_names import PythonNames

_LANGUAGE = re.compile(r"[A-Za-z0-9][A-Za-z0-9+#.]{0,15}")


class ComponentsBackend:
    """Generates a package for each component, its skeleton, and the table of factories."""

    name = "components"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all components; none where a component has errors."""
        packages = list(parts(model, options))
        diagnostics: list[Diagnostic] = []
        for part in packages:
            diagnostics += check(part.model)
        diagnostics += check_skeletons(packages)
        if has_errors(diagnostics):
            return Emission((), diagnostics)
        artifacts: dict[str, Artifact] = {}
        for part in packages:
            for artifact in _of_part(part):
                # Boards with a signature of one name share the skeleton of its client.
                artifacts.setdefault(artifact.path, artifact)
        return Emission(list(artifacts.values()), diagnostics, _types(packages))


BACKEND = ComponentsBackend()


def _of_part(part: Part) -> Iterator[Artifact]:
    """The packages of a part's own components, with the folder they are in, and skeletons."""
    components = own_components(part.model)
    options = part.options
    if apart := [each for each in components if not each.module]:
        yield python_module(
            f"{components_folder(options)}/__init__.py",
            options,
            part.origin or (source_of(part.model, each).key for each in apart),
            "The components, each in a package of its own.",
            plain=True,
        )
    names = PythonNames(part.model, options.package)
    modules: dict[str, list[PythonModule]] = {}
    for component in components:
        base = base_module(
            part.model, names, component, options, _origin(part, component)
        )
        modules.setdefault(base.path, []).append(base)
    yield from map(composed, modules.values())
    for component in components:
        if not component.factory:
            skeleton = skeleton_module(part.model, names, component, options)
            module = skeleton_location(component, options).rpartition(".")[2]
            origin = _origin(part, component)
            yield Artifact(f"{module}.py", skeleton, origin, Owner.USER)


def _origin(part: Part, component: Component) -> tuple[str, ...]:
    return part.origin or (source_of(part.model, component).key,)


def _types(packages: Sequence[Part]) -> ComponentTypes:
    """Return all component types; of two types with one name, that of the first part."""
    types = ComponentTypes()
    for part in packages:
        components = components_of(part.model)
        types = types.joined(
            ComponentTypes(
                {c.name[-1]: ":".join(factory(c, part.options)) for c in components},
                {c.name[-1]: _language(c) for c in components if c.is_foreign},
            )
        )
    return types


def _language(component: Component) -> str:
    """Return the language of a profile, if its name is valid."""
    match = _LANGUAGE.fullmatch(component.language)
    return component.language if match else "another language"
