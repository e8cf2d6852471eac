"""The files of the target small, in addition to those of the embedded target."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.components.checks import check, components_of
from rtgen.compiler.backends.kit.python_text import header_comment
from rtgen.compiler.backends.small import modules
from rtgen.compiler.backends.small.forms import Forms, Limits, NoFormError, reachable
from rtgen.compiler.backends.small.rules import LEFT_OUT
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.model import (
    Component,
    Const,
    Enum,
    Model,
    NamedType,
    PortKind,
    ScopedName,
    SequenceType,
    Struct,
)
from rtgen.compiler.typemap.python.idl_names import PythonNames, package_path
from rtgen.compiler.typemap.python.names import module_name

ROOT = "small"
"""Folder below the output folder, to be copied to a board."""
RUNTIME = (
    *("__init__.py", "codes.py", "components.py", "ports.py", "sequences.py"),
    *("system.py", "wire.py"),
)
"""The modules of the small runtime, copied unchanged."""
_DATA = (PortKind.INPORT, PortKind.OUTPORT)


class SmallBackend:
    """Generates a tree that replaces the runtime and the generated package."""

    name = "small"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return all files of all components that have a small form."""
        if has_errors(check(model)):
            return Emission()
        names = PythonNames(model, options.package)
        limits = Limits(*options.small)
        components, findings = _fit(model, limits)
        if not components:
            return Emission((), findings)
        tree = _Tree(model, names, options, limits, components)
        return Emission(tuple(tree.artifacts()), findings)


BACKEND = SmallBackend()


def _fit(model: Model, limits: Limits) -> tuple[list[Component], list[Diagnostic]]:
    """Return the components with a small form, and the reasons why others have none."""
    fitting: list[Component] = []
    findings: list[Diagnostic] = []
    for component in components_of(model):
        try:
            _check(model, component, limits)
        except NoFormError as error:
            findings.append(
                LEFT_OUT.at(
                    component.span,
                    f"{component.scoped} has no small form: {error}",
                    hint="it is left out; `rtgen explain RTC0600` lists what fits",
                )
            )
        else:
            fitting.append(component)
    return fitting, findings


def _check(model: Model, component: Component, limits: Limits) -> None:
    if component.runtime_base or component.factory:
        raise NoFormError("it is made for the embedded runtime")
    for parameter in component.configuration:
        if isinstance(model.unalias(parameter.type), SequenceType):
            raise NoFormError(f"the parameter {parameter.name} is a sequence")
    for port in component.ports:
        if port.kind not in _DATA:
            raise NoFormError(f"{port.name} is a service port")
        struct = model.declared(port.type)
        if not isinstance(struct, Struct):
            raise NoFormError(f"the type of {port.name} is not a struct")
        needed = reachable(model, struct.name)
        forms = Forms(model, limits, dict.fromkeys(needed, "_"))
        for name in needed:
            declaration = model.find(name)
            if isinstance(declaration, Struct):
                for member in declaration.members:
                    forms.form(member.type, member.initial)


@dataclass(slots=True)
class _Tree:
    model: Model
    names: PythonNames
    options: Options
    limits: Limits
    components: Sequence[Component]

    def artifacts(self) -> Iterator[Artifact]:
        """Yield runtime, types, packages, components."""
        used = self._used()
        classes = modules.type_names(self.model, self.names, used)
        root = f"{ROOT}/{self.options.folder}"
        forms = Forms(self.model, self.limits, classes)
        yield self._artifact(f"{ROOT}/rtgen/__init__.py", "", self.components)
        for name in RUNTIME:
            source = files("rtgen.small_runtime").joinpath(name)
            text = source.read_text(encoding="utf-8")
            yield self._artifact(f"{ROOT}/rtgen/runtime/{name}", text, self.components)
        types = modules.types_module(self.model, self.names, used, classes, forms)
        yield self._artifact(f"{root}/_types.py", types, self.components)
        for scope, text in self._packages(used, classes):
            path = "/".join((root, *package_path(scope), "__init__.py"))
            yield self._artifact(path, text, self.components)
        yield self._artifact(f"{root}/components/__init__.py", "", self.components)
        for component in self.components:
            module = module_name(component.name[-1])
            text = modules.component_module(
                self.model, self.names, component, self.options
            )
            path = f"{root}/components/{module}.py"
            yield self._artifact(path, text, [component])

    def _used(self) -> list[ScopedName]:
        names: dict[ScopedName, None] = {}
        for component in self.components:
            for port in component.ports:
                type_ = self.model.unalias(port.type)
                assert isinstance(type_, NamedType), "checked before"
                names.update(dict.fromkeys(reachable(self.model, type_.name)))
        # Enums and constants of the same IDL modules, for comparisons in behaviours.
        scopes = {name[:-1] for name in names}
        for declaration in self.model.declarations:
            if declaration.name[:-1] in scopes and isinstance(declaration, Enum):
                names.setdefault(declaration.name)
        return [d.name for d in self.model.declarations if d.name in names]

    def _packages(
        self, used: Iterable[ScopedName], classes: dict[ScopedName, str]
    ) -> Iterator[tuple[ScopedName, str]]:
        scopes: dict[ScopedName, list[ScopedName]] = {(): []}
        for name in used:
            for depth in range(len(name)):
                scopes.setdefault(name[:depth], [])
            scopes[name[:-1]].append(name)
        for scope, inside in scopes.items():
            constants = [
                declaration
                for declaration in self.model.declarations
                if isinstance(declaration, Const) and declaration.name[:-1] == scope
            ]
            yield scope, modules.package(
                self.names, scope, {name: classes[name] for name in inside}, constants
            )

    def _artifact(
        self, path: str, text: str, components: Sequence[Component]
    ) -> Artifact:
        files = {component.file for component in components}
        sources = [file for file in self.model.files if file.name in files]
        keys = tuple(file.key for file in sources)
        return Artifact(
            path,
            header_comment(self.options.version, keys) + text,
            keys,
        )
