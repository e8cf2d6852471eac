"""Plan of the target openrtm, shared by its parts: packages, components, ports, IDL files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePosixPath

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.checks import components_of
from rtgen.compiler.backends.components.locations import (
    factory,
    imported_from,
    source_of,
)
from rtgen.compiler.backends.components.members import attributes_of
from rtgen.compiler.backends.kit.quoting.properties import is_conf_key, is_conf_value
from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.kit.words import words
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Declaration,
    Home,
    Model,
    Port,
    PortKind,
    ScopedName,
    SourceFile,
    graphs,
)
from rtgen.compiler.typemap.openrtm_ports import (
    OPENRTM_NAME,
    chosen_name,
    key_of,
    names_of,
)
from rtgen.compiler.typemap.python.implementation_modules import (
    implementation_modules,
    referred,
)
from rtgen.compiler.typemap.python.names import identifier
from rtgen.facts import python_modules
from rtgen.facts.openrtm_ports import known_name
from rtgen.openrtm.backend import rules

ROOT = "openrtm"
"""The folder of all modules and systems, below the output folder."""

STOCK = words("""
    BasicDataType ExtendedDataTypes InterfaceDataTypes RTC SDOPackage OpenRTM DataPort
    DataPort_OpenRTM Manager
    """)
"""Stems of OpenRTM's own IDL files: included from its folder, never generated."""

_STOCK_STEMS = {stem.casefold(): "" for stem in STOCK}
_NOT_IN_STEM = re.compile(r"\W", re.ASCII)
_NO_TYPES = (Component, Home)


@dataclass(frozen=True, slots=True)
class IdlFile:
    """An IDL file for omniidl: `<stem>.idl` gives the module `<stem>_idl`.

    `module` is the implementation module of its types (`_idl/<module>.py`), `files` are the
    displayed paths of the definition files that share it. A stock file is one of
    OpenRTM's.
    """

    stem: str
    module: str
    files: tuple[str, ...]
    stock: bool


@dataclass(frozen=True)
class Unit:
    """A generated Python package: the project's own, or one of its TECS packages.

    `options.package` is the package. `factories` has `module:name` for component types whose
    behaviour is not in a skeleton.
    """

    model: Model
    options: Options
    factories: Mapping[str, str] = field(default_factory=dict)

    @property
    def components(self) -> list[Component]:
        """The components of the package."""
        return components_of(self.model)

    @cached_property
    def idl_files(self) -> tuple[IdlFile, ...]:
        """All files with types or interfaces, each after its dependencies."""
        modules = implementation_modules(self.model)
        groups: dict[str, list[str]] = {}
        for file in self.model.files:
            groups.setdefault(modules[file.name], []).append(file.name)
        with_types = {
            modules[d.file]
            for d in self.model.declarations
            if not isinstance(d, _NO_TYPES)
        }
        stems: dict[str, str] = {}
        by_name: dict[str, IdlFile] = {}
        for module, files in groups.items():
            if module not in with_types:
                continue
            stem = PurePosixPath(files[0]).stem
            stock = files[0].endswith(".idl") and stem in STOCK
            plain = name = identifier(_NOT_IN_STEM.sub("_", stem))
            number = 1
            taken = {**_STOCK_STEMS, **stems}
            while not stock and taken.get(name.casefold(), module) != module:
                number += 1
                name = f"{plain}_{number}"
            stems[name.casefold()] = module
            by_name[module] = IdlFile(name, module, tuple(files), stock)
        needed = {m: [n for n in by_name if n in self._needs[m]] for m in by_name}
        return tuple(by_name[module] for [module] in graphs.groups(needed))

    def needs(self, file: IdlFile) -> tuple[IdlFile, ...]:
        """Return the files used by a file's declarations, in order of `idl_files`."""
        modules = self._needs[file.module]
        return tuple(each for each in self.idl_files if each.module in modules)

    def closure(self, names: Iterable[ScopedName]) -> tuple[IdlFile, ...]:
        """Return the files for types and interfaces of these names, each after its dependencies."""
        modules = implementation_modules(self.model)
        own = [modules[self.model.find(name).file] for name in names]
        needed = graphs.reached(own, self._needs.__getitem__)
        return tuple(each for each in self.idl_files if each.module in needed)

    @cached_property
    def _needs(self) -> dict[str, set[str]]:
        modules = implementation_modules(self.model)
        owners = {d.name: modules[d.file] for d in self.model.declarations}
        needs: dict[str, set[str]] = {}
        for declaration in self.model.declarations:
            if isinstance(declaration, _NO_TYPES):
                continue
            own = owners[declaration.name]
            others = {owners[name] for name in referred(declaration) if name in owners}
            needs.setdefault(own, set()).update(others - {own})
        return needs


@dataclass(frozen=True, slots=True)
class DataPort:
    """A data port: `name` is OpenRTM's, `attribute` the behaviour's; `type` is not an alias."""

    port: Port
    name: str
    attribute: str
    type: Declaration


@dataclass(frozen=True, slots=True)
class ServiceInterface:
    """A provided or required interface: `attribute` is the behaviour's."""

    port: Port
    attribute: str
    type: Declaration

    @property
    def type_name(self) -> str:
        """The name under which the interface's type is registered."""
        return self.port.type_name or self.type.scoped

    @property
    def provided(self) -> bool:
        """Whether it is a provider."""
        return self.port.kind is PortKind.PROVIDER


@dataclass(frozen=True, slots=True)
class ServicePort:
    """A service port: `name` is OpenRTM's, `port` the definition's."""

    name: str
    port: str
    interfaces: tuple[ServiceInterface, ...]


@dataclass(frozen=True, slots=True)
class PlannedParameter:
    """A configuration parameter and its attribute in the configuration object."""

    parameter: ConfigurationParameter
    attribute: str


@dataclass(frozen=True)
class ComponentPlan:
    """A component for OpenRTM."""

    unit: Unit
    component: Component
    in_ports: tuple[DataPort, ...]
    out_ports: tuple[DataPort, ...]
    service_ports: tuple[ServicePort, ...]
    parameters: tuple[PlannedParameter, ...]

    @property
    def name(self) -> str:
        """The component type, also the name of module, class and folder."""
        return self.component.name[-1]

    @property
    def folder(self) -> str:
        """The folder, relative to the output folder."""
        return f"{ROOT}/{self.name}"

    @property
    def source(self) -> SourceFile:
        """The file that defines it."""
        return source_of(self.unit.model, self.component)

    @property
    def is_foreign(self) -> bool:
        """Whether its profile names another language, and the project has no factory for it."""
        return self.component.is_foreign and self.name not in self.unit.factories

    @property
    def behaviour(self) -> tuple[str, str]:
        """Module and name of the factory of the behaviour."""
        options = self.unit.options
        named = self.unit.factories.get(self.name)
        return (
            imported_from(options, named) if named else factory(self.component, options)
        )

    @property
    def behaviour_file(self) -> str | None:
        """The file of the behaviour, relative to the folder from which skeletons are imported.

        None if it can be imported by name: OpenRTM's manager imports `<Component>.py` as
        `<Component>`, which a skeleton at the top level may be called, too.
        """
        module, _ = self.behaviour
        is_skeleton = not (self.unit.factories.get(self.name) or self.component.factory)
        return f"{module}.py" if is_skeleton and module == self.name else None

    @cached_property
    def idl_files(self) -> tuple[IdlFile, ...]:
        """The IDL files needed by its ports, each after its dependencies."""
        data = (port.type.name for port in (*self.in_ports, *self.out_ports))
        services = (i.type.name for port in self.service_ports for i in port.interfaces)
        return self.unit.closure((*data, *services))

    @property
    def own_idl_files(self) -> tuple[IdlFile, ...]:
        """The IDL files except those of OpenRTM."""
        return tuple(file for file in self.idl_files if not file.stock)


def openrtm_port_name(component: Component, port: Port) -> str:
    """Return the registration name of a port, without the instance's name."""
    return names_of(component)[key_of(port)]


def plans(units: Sequence[Unit]) -> tuple[list[ComponentPlan], list[Diagnostic]]:
    """Return the plans of all components, in order of the units, with diagnostics."""
    planned: list[ComponentPlan] = []
    findings: list[Diagnostic] = []
    folders: dict[str, Component] = {}
    for unit in units:
        for component in unit.components:
            findings += _port_findings(component)
            findings += _text_findings(component)
            first = folders.setdefault(component.name[-1].casefold(), component)
            if first is not component:
                findings.append(
                    rules.SAME_FOLDER.at(
                        component.span,
                        f"`{component.scoped}` and `{first.scoped}` both get the folder "
                        f"`{ROOT}/{component.name[-1]}`",
                        related=[Related(first.span, "the other component")],
                        hint="rename one of them",
                    )
                )
            planned.append(_plan(unit, component))
    findings += _hiding(planned)
    return planned, findings


def own_modules(planned: Iterable[ComponentPlan]) -> set[str]:
    """Return the project's top-level modules that modules for OpenRTM import by name."""
    imported = (
        module
        for plan in planned
        for module in (
            plan.unit.options.package,
            *(() if plan.behaviour_file else (plan.behaviour[0],)),
        )
    )
    return {module.partition(".")[0] for module in imported}


def _hiding(planned: Sequence[ComponentPlan]) -> Iterator[Diagnostic]:
    """Yield diagnostics for modules with the name of one that they import."""
    own = own_modules(planned)
    for plan in planned:
        name = plan.name
        if name in own or python_modules.owner(name):
            message = f"`{name}.py` would hide the module {name} that it imports"
            hint = "rename the component"
            yield rules.HIDES.at(plan.component.span, message, hint=hint)


def _plan(unit: Unit, component: Component) -> ComponentPlan:
    names = names_of(component)
    attributes = attributes_of(component)
    data: dict[PortKind, list[DataPort]] = {PortKind.INPORT: [], PortKind.OUTPORT: []}
    services: dict[tuple[str, str], list[ServiceInterface]] = {}
    for port, attribute in attributes.ports:
        declaration = unit.model.declared(port.type)
        assert declaration is not None, "checked before anything is emitted"
        key = key_of(port)
        if port.kind in data:
            planned = DataPort(port, names[key], attribute, declaration)
            data[port.kind].append(planned)
        else:
            interface = ServiceInterface(port, attribute, declaration)
            services.setdefault(key, []).append(interface)
    return ComponentPlan(
        unit=unit,
        component=component,
        in_ports=tuple(data[PortKind.INPORT]),
        out_ports=tuple(data[PortKind.OUTPORT]),
        service_ports=tuple(
            ServicePort(names[key], key[1], tuple(interfaces))
            for key, interfaces in services.items()
        ),
        parameters=tuple(PlannedParameter(*each) for each in attributes.configuration),
    )


def _text_findings(component: Component) -> Iterator[Diagnostic]:
    """Yield diagnostics for texts that configuration files cannot represent."""
    for what, text, fits in (
        ("category", component.category, is_conf_key),
        ("kind of execution context", component.execution, is_conf_value),
    ):
        if not fits(text):
            message = f"the {what} {text!r} cannot be written to rtc.conf"
            yield rules.CONF_TEXT.at(component.span, message)


def _port_findings(component: Component) -> Iterator[Diagnostic]:
    names = names_of(component)
    chosen: dict[tuple[str, str], Port] = {}
    for port in component.ports:
        if not chosen_name(port):
            continue
        other = chosen.setdefault(key_of(port), port)
        if chosen_name(other) != chosen_name(port):
            yield rules.TWO_NAMES.at(
                port.span,
                f"the service port {port.port!r} is called {chosen_name(other)!r} "
                f"and {chosen_name(port)!r}",
                related=[Related(other.span, "the other name")],
                hint="say it at one of its interfaces",
            )
    distinct: dict[tuple[str, str], Port] = {}
    for port in component.ports:
        distinct.setdefault(key_of(port), port)
    first: dict[str, Port] = {}
    for key, port in distinct.items():
        name = known_name(names[key])
        taken = first.setdefault(name, port)
        if taken is not port:
            yield rules.SAME_NAME.at(
                port.span,
                f"OpenRTM would know two ports of `{component.scoped}` as {name!r}",
                related=[Related(taken.span, "the other port")],
                hint=f'give one another name: @{OPENRTM_NAME}("...")',
            )
        elif names[key] != key[1] and key not in chosen:
            yield rules.RENAMED.at(
                port.span,
                f"OpenRTM will know this port of `{component.scoped}` as {name!r}",
                hint=f'choose the name: @{OPENRTM_NAME}("{name}")',
            )
