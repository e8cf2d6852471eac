"""Prints `<Component>.py`, the module that OpenRTM's manager loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath

from rtgen.compiler.backends.components.locations import heading, summary
from rtgen.compiler.backends.kit.python_text import (
    fit_text,
    header_comment,
    tuple_of,
)
from rtgen.compiler.backends.kit.quoting.python import (
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.kit.words import words
from rtgen.compiler.model import Declaration, Interface, SequenceType, StringType
from rtgen.compiler.typemap.components.actions import ACTIONS
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.names import identifier
from rtgen.facts.constraints import text_of
from rtgen.openrtm.backend.plan import (
    ComponentPlan,
    DataPort,
    PlannedParameter,
    ServiceInterface,
    ServicePort,
)
from rtgen.openrtm.backend.stub_names import StubNames

_RESERVED = words("""
    Any FOLDER Host MyModuleInit OpenRTM_aist Path RTC behaviour_module annotations
    instance_arguments main path place stubs sys int str host manager profile self ec_id wire
    """)


@dataclass(frozen=True, slots=True)
class _Servant:
    """Class that serves an interface: omniORB's skeleton, and rtgen's class."""

    name: str
    skeleton: str
    type: str
    interface: str


def component_module(plan: ComponentPlan) -> str:
    """Return the text of the module."""
    return _ComponentModule(plan).text()


class _ComponentModule:
    def __init__(self, plan: ComponentPlan) -> None:
        self._plan = plan
        self._theirs = StubNames(plan.unit.model)
        self._ours = PythonNames(plan.unit.model, plan.unit.options.package)
        self._parameters = Parameters(plan.unit.model)
        self._class = identifier(plan.name, _RESERVED)
        self._names = {*_RESERVED, self._class}
        self._specification = self._own(f"{plan.name.lower()}_spec")
        self._own(f"{plan.name}Init")
        self._attributes: dict[tuple[str, str], str] = {}
        self._modules: dict[str, str] = {}
        self._stubs: dict[str, str] = {}
        self._servants: dict[str, _Servant] = {}

    def _own(self, name: str) -> str:
        """Return a unique name for use in the module."""
        name = identifier(name, self._names)
        self._names.add(name)
        return name

    def text(self) -> str:
        plan = self._plan
        options, component = plan.unit.options, plan.component
        module, _, class_name = ":".join(plan.behaviour).partition(":")
        head, dot, rest = class_name.partition(".")
        behaviour = self._own(f"{identifier(head)}Behaviour")
        members = list(self._members())
        initialization = list(self._initialization())
        source = plan.source
        imports = []
        if plan.behaviour_file is None:
            imports.append(f"from {module} import {identifier(head)} as {behaviour}")
        imports += [
            self._import(path, local) for path, local in sorted(self._modules.items())
        ]
        imports += [
            f"import {name}" if name == local else f"import {name} as {local}"
            for name, local in self._stubs.items()
            if name != "RTC"
        ]
        outside = "/".join(".." for _ in PurePosixPath(plan.folder).parts)
        names = ["Host", "instance_arguments", "main"]
        loaded = ""
        if plan.behaviour_file is not None:
            names = ["Host", "behaviour_module", *names[1:]]
            file = string_literal(
                f"{outside}/{options.skeleton_path}/{plan.behaviour_file}"
            )
            loaded = (
                f"{behaviour} = behaviour_module(FOLDER / {file}).{identifier(head)}"
            )
        stems = [file.stem for file in plan.own_idl_files]
        names += ["stubs"] * bool(stems)
        names += ["wire"] * bool(plan.in_ports or plan.out_ports or self._servants)
        places = [f"{outside}/{options.skeleton_path}", outside]
        text = render(
            "openrtm/component.py.j2",
            header=header_comment(options.version, [source.key]),
            docstring=docstring(heading(component), 0),
            class_docstring=docstring(component.doc, 4, heading(component)),
            places=tuple_of([*map(string_literal, places)]).flat,
            runtime=", ".join(names),
            stubs=tuple_of([*map(string_literal, stems)]).flat if stems else "",
            imports=sorted(imports),
            loaded=loaded,
            specification=self._specification_text(),
            specification_name=self._specification,
            servants=list(self._servants.values()),
            name=self._class,
            component=plan.name,
            behaviour=behaviour + dot + rest,
            members=members,
            initialization=initialization,
            callbacks=[
                (f"o{action.element[1:]}", action.method)
                for action in ACTIONS
                if action.parameters
            ],
            type_name=plan.name,
            category=component.category,
        )
        return fit_text(text)

    def _specification_text(self) -> str:
        """Return the module spec: one pair per line, in OpenRTM's usual form."""
        pairs = (map(string_literal, pair) for pair in self._entries())
        lines = "".join(f"    {', '.join(pair)},\n" for pair in pairs)
        return f'# fmt: off\n{self._specification} = [\n{lines}    "",\n]\n# fmt: on'

    def _import(self, path: str, local: str) -> str:
        package, _, name = path.rpartition(".")
        return f"from {package} import {name}" + f" as {local}" * (name != local)

    # Module spec

    def _entries(self) -> Iterator[tuple[str, str]]:
        component = self._plan.component
        yield "implementation_id", self._plan.name
        yield "type_name", self._plan.name
        yield "description", summary(component)
        yield "version", component.version
        yield "vendor", component.vendor
        yield "category", component.category
        yield "activity_type", component.registered_activity
        yield "max_instance", str(component.max_instances)
        yield "language", "Python"
        yield "lang_type", "SCRIPT"
        yield "exec_cxt.periodic.type", component.execution
        yield "exec_cxt.periodic.rate", number_literal(float(component.rate))
        for planned in self._plan.parameters:
            yield from self._parameter_entries(planned)

    def _parameter_entries(
        self, planned: PlannedParameter
    ) -> Iterator[tuple[str, str]]:
        parameter = planned.parameter
        name = parameter.name
        constraint = self._parameters.constraint(parameter)
        yield f"conf.default.{name}", self._parameters.default_text(parameter)
        yield f"conf.__widget__.{name}", parameter.widget or "text"
        if constraint is not None:
            yield f"conf.__constraints__.{name}", text_of(constraint)
        yield f"conf.__type__.{name}", self._parameters.profile_type(parameter.type)

    # Attributes of the class: items that differ in the definition have different names here

    def _attribute(self, kind: str, key: str, name: str) -> str:
        """Return an item's attribute, by kind and key: its name, with `_` appended if necessary."""
        attribute = self._attributes.get((kind, key))
        if attribute is None:
            taken = self._attributes.values()
            while name in taken:
                name += "_"
            attribute = self._attributes[kind, key] = name
        return attribute

    def _datum(self, port: DataPort) -> str:
        return self._attribute("datum", port.attribute, f"_d_{port.attribute}")

    def _member(self, port: DataPort, kind: str) -> str:
        return self._attribute("port", port.attribute, f"_{port.attribute}{kind}")

    def _service_member(self, service: ServicePort) -> str:
        name = f"_{identifier(service.name)}Port"
        return self._attribute("service", service.name, name)

    def _interface_member(self, interface: ServiceInterface) -> str:
        attribute = interface.attribute
        return self._attribute("interface", attribute, f"_s_{attribute}")

    def _variable(self, planned: PlannedParameter) -> str:
        # Not `_<name>`, as tools write: OpenRTM's own members have such names, as `_properties`.
        attribute = planned.attribute
        return self._attribute("parameter", attribute, f"_c_{attribute}")

    # Constructor

    def _members(self) -> Iterator[str]:
        plan = self._plan
        for ports, kind in ((plan.in_ports, "In"), (plan.out_ports, "Out")):
            for port in ports:
                datum, member = self._datum(port), self._member(port, kind)
                type_ = self._stub(self._theirs.stub_path(port.type.name))
                yield f"self.{datum}: {type_} = wire.new({self._type(port.type)})"
                port_text = f"OpenRTM_aist.{kind}Port({string_literal(port.name)}, self.{datum})"
                yield f"self.{member} = {port_text}"
        for service in plan.service_ports:
            port_text = f"OpenRTM_aist.CorbaPort({string_literal(service.name)})"
            yield f"self.{self._service_member(service)} = {port_text}"
            for interface in service.interfaces:
                if not interface.provided:
                    stub = self._stub(self._theirs.stub_path(interface.type.name))
                    port_text = f"OpenRTM_aist.CorbaConsumer(interfaceType={stub})"
                    yield f"self.{self._interface_member(interface)} = {port_text}"
        for planned in plan.parameters:
            initial = self._initial(planned)
            annotation = ": list[Any]" * (initial == "[]")
            yield f"self.{self._variable(planned)}{annotation} = [{initial}]"

    def _type(self, declaration: Declaration) -> str:
        """Return rtgen's class of a type or interface, with the import of its module."""
        names = self._ours
        if names.is_own(declaration.name):
            home, local = names.implementation(declaration.name)
            return f"{self._module(home)}.{local}"
        path, attribute = names.public(declaration.name)
        package = names.public_package(declaration.name)
        outer, dot, inner = ".".join((*path, attribute)).partition(".")
        return self._module(f"{package}.{outer}") + dot + inner

    def _module(self, path: str) -> str:
        """Return a module of types, or a class in a package, under its local name."""
        module = self._modules.get(path)
        if module is None:
            module = self._modules[path] = self._own(path.rpartition(".")[2])
        return module

    def _stub(self, path: str) -> str:
        """Return a class of stubs, with the import of its package."""
        package, dot, rest = path.partition(".")
        if package not in self._stubs:
            fine = package == "RTC" or package not in self._names
            self._stubs[package] = package if fine else self._own(package)
            self._names.add(package)
        return self._stubs[package] + dot + rest

    def _initial(self, planned: PlannedParameter) -> str:
        """Return the default as a Python value, from which tools infer the type."""
        parameter = planned.parameter
        type_ = self._plan.unit.model.unalias(parameter.type)
        default = parameter.default
        if isinstance(type_, SequenceType):
            items = self._parameters.default_items(parameter)
            inner = self._plan.unit.model.unalias(type_.element)
            values = [self._parameters.parse_item(inner, item) for item in items]
            plain = all(isinstance(value, int | float | str) for value in values)
            shown = values if plain else items
            return f"[{', '.join(map(_literal, shown))}]"
        if isinstance(default, bool | int | float | str):
            return _literal(default)
        text = self._parameters.default_text(parameter)
        word = self._parameters.profile_type(parameter.type)
        if default is None and not isinstance(type_, StringType) and word != "string":
            return text if word != "bool" else "False"
        return string_literal(text)

    # onInitialize

    def _initialization(self) -> Iterator[str]:
        plan = self._plan
        for planned in plan.parameters:
            name = string_literal(planned.parameter.name)
            # An empty default would not be bound.
            default = self._parameters.default_text(planned.parameter) or " "
            yield (
                f"self.bindParameter({name}, self.{self._variable(planned)}, "
                f"{string_literal(default)}, host.parameter({name}))"
            )
        for ports, kind in ((plan.in_ports, "In"), (plan.out_ports, "Out")):
            for port in ports:
                member = f"self.{self._member(port, kind)}"
                yield f"self.add{kind}Port({string_literal(port.name)}, {member})"
                yield (
                    f"host.{kind.lower()}_port({string_literal(port.port.name)}, {member}, "
                    f"self.{self._datum(port)})"
                )
        for service in plan.service_ports:
            yield from self._served(service)

    def _served(self, service: ServicePort) -> Iterator[str]:
        port = f"self.{self._service_member(service)}"
        for interface in service.interfaces:
            member = f"self.{self._interface_member(interface)}"
            type_ = string_literal(interface.type_name)
            instance = string_literal(interface.port.instance)
            place = f"{string_literal(service.port)}, {instance}"
            if interface.provided:
                servant = self._servant(interface)
                yield f"{member} = {servant}(host.servant({place}))"
                yield f"{port}.registerProvider({instance}, {type_}, {member})"
            else:
                yield f"{port}.registerConsumer({instance}, {type_}, {member})"
                yield f"host.consumer({place}, {member})"
        if not all(interface.provided for interface in service.interfaces):
            yield f"host.service_port({string_literal(service.port)}, {port})"
        yield f"self.addPort({port})"

    def _servant(self, interface: ServiceInterface) -> str:
        type_ = interface.type
        assert isinstance(type_, Interface), "checked before anything is emitted"
        if type_.scoped not in self._servants:
            self._servants[type_.scoped] = _Servant(
                name=self._own(f"{type_.name[-1]}_i"),
                skeleton=self._stub(self._theirs.skeleton_path(type_)),
                type=self._type(type_),
                interface=type_.scoped,
            )
        return self._servants[type_.scoped].name


def _literal(value: object) -> str:
    if isinstance(value, str):
        return string_literal(value)
    return number_literal(value) if isinstance(value, float) else repr(value)
