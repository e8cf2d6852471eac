"""Prints the package of a component: configuration class, profile and base class."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from rtgen.backends import Options
from rtgen.backends.components.imports import Imports
from rtgen.backends.components.locations import (
    base_location,
    heading,
    imported_from,
    module_path,
    summary,
)
from rtgen.backends.components.members import Attributes, attributes_of
from rtgen.backends.kit.python_initial import PythonInitial
from rtgen.backends.kit.python_module import (
    Import,
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.backends.kit.quoting.python import docstring, number_literal, string_literal
from rtgen.backends.kit.rendering import render
from rtgen.facts.constraints import parse, text_of
from rtgen.model import (
    Component,
    ConfigurationParameter,
    ConstantValue,
    Declaration,
    EnumeratorName,
    Model,
    NamedType,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    SequenceType,
    Type,
)
from rtgen.typemap.components.names import CONFIGURATION_NAMES
from rtgen.typemap.components.parameters import Parameters
from rtgen.typemap.member_units import with_unit
from rtgen.typemap.python.idl_names import PythonNames
from rtgen.typemap.python.support import BASE_NAMES, CANOPEN_NAMES

_TAKEN = CONFIGURATION_NAMES | BASE_NAMES | {"super", "self", "instance_name"}
_FLOATING = (PrimitiveType(Primitive.FLOAT), PrimitiveType(Primitive.DOUBLE))
_ADD = {PortKind.INPORT: "add_in_port", PortKind.OUTPORT: "add_out_port"}
_PROFILES = {
    PortKind.INPORT: "data_port",
    PortKind.OUTPORT: "data_port",
    PortKind.PROVIDER: "service_port",
    PortKind.CONSUMER: "service_port",
}
"""The functions of the runtime that make the profile of a port."""
_ADD_SERVICE = {PortKind.PROVIDER: "add_provider", PortKind.CONSUMER: "add_consumer"}


@dataclass(frozen=True, slots=True)
class _Statement:
    """An assignment, unsplit, and the docstring below it."""

    text: str
    docstring: str


def class_names(component: Component) -> tuple[str, str]:
    """The names of the base class and of the configuration class."""
    name = component.name[-1]
    return f"{name}Base", f"{name}Configuration"


def attribute_names(
    model: Model, names: PythonNames, component: Component
) -> Attributes:
    """The attributes for ports and parameters, for all targets."""
    return _attributes(model, component, component_imports(model, names, component))


def component_imports(
    model: Model,
    names: PythonNames,
    component: Component,
    further: Collection[str] = (),
) -> Imports:
    """Return the imports of the module with the base of a component.

    `further` are names of definitions that no module may bind.
    """
    taken = _TAKEN | {*class_names(component), *further}
    if component.runtime_base:
        taken |= CANOPEN_NAMES | {component.runtime_base.partition(":")[2]}
    return Imports(model, names, taken, base_location(names.package, component))


def _attributes(model: Model, component: Component, imports: Imports) -> Attributes:
    for parameter in component.configuration:
        imports.mapping.annotation(model.unalias(parameter.type))
    return attributes_of(component, imports.locals)


def base_module(
    model: Model,
    names: PythonNames,
    component: Component,
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    """Return the module of a component without errors; `origin` are the keys of its inputs."""
    return _BaseModule(model, names, component, options).module(origin)


class _BaseModule:
    def __init__(
        self, model: Model, names: PythonNames, component: Component, options: Options
    ) -> None:
        self._model = model
        self._component = component
        self._options = options
        self._parameters = Parameters(model)
        self._base, self._configuration = class_names(component)
        self._names = names
        self._imports = component_imports(model, names, component)
        self._initial = PythonInitial(self._imports.mapping)

    def module(self, origin: Sequence[str]) -> PythonModule:
        component = self._component
        attributes = _attributes(self._model, component, self._imports)
        fields = [self._field(p, name) for p, name in attributes.configuration]
        ports = [self._port(port, name) for port, name in attributes.ports]
        title = heading(component)
        runtime_base = self._runtime_base()
        body = render(
            "components/base.py.j2",
            class_docstring=docstring(component.doc, 4, title),
            runtime_base=runtime_base.name,
            name=component.name[-1],
            base=self._base,
            configuration=self._configuration,
            fields=fields,
            ports=ports,
            profile=self._profile(attributes),
        )
        runtime = ["ComponentProfile", *["ParameterProfile"] * bool(fields)]
        runtime += {_PROFILES[port.kind] for port, _ in attributes.ports}
        of_fields = ["Struct"] * bool(fields)
        of_fields += ["field"] * any("= field(" in field.text for field in fields)
        return python_module(
            module_path(self._names.package, component),
            self._names.package,
            self._options.version,
            origin,
            title,
            imports=[
                *imports_from("typing", ["ClassVar"]),
                *imports_from("msgspec", of_fields),
                *imports_from("rtgen.runtime", runtime),
                runtime_base,
                *self._imports.imports(),
            ],
            body=body,
            defines=[self._base, self._configuration],
        )

    def _runtime_base(self) -> Import:
        """Return the parent class, of the runtime or generated."""
        parent = self._component.runtime_base or "rtgen.runtime:Component"
        module, name = imported_from(self._options, parent)
        return Import(module, name, name)

    # The configuration class.

    def _field(self, parameter: ConfigurationParameter, name: str) -> _Statement:
        mapping = self._imports.mapping
        type_ = self._model.unalias(parameter.type)
        if isinstance(type_, SequenceType):
            value = self._sequence(type_, self._parameters.default_items(parameter))
        elif parameter.default is None:
            value = self._initial.expression(type_)
        else:
            value = self._literal(type_, parameter.default)
        text = f"{name}: {mapping.annotation(type_)} = {value}"
        return _Statement(text, docstring(with_unit(parameter.doc, parameter.unit), 4))

    def _sequence(self, type_: SequenceType, texts: Sequence[str]) -> str:
        mapping = self._imports.mapping
        item = self._model.unalias(type_.element)
        values = [
            self._literal(item, self._parameters.parse_item(item, text))
            for text in texts
        ]
        if mapping.is_text(type_):
            if not values:
                return self._initial.expression(type_)
            return f"bytes([{', '.join(values)}])"
        factory = self._initial.factory(type_)
        if values:
            factory = f"lambda: [{', '.join(values)}]"
        return f"field(default_factory={factory})"

    def _literal(self, type_: Type, value: ConstantValue) -> str:
        match value:
            case EnumeratorName(name):
                enum = self._imports.mapping.annotation(type_)
                return f"{enum}.{self._names.enumerator(name)[1]}"
            case str():
                return string_literal(value)
            case int() | float() if type_ in _FLOATING:
                return number_literal(float(value))
            case _:
                return repr(value)

    # The ports.

    def _port(self, port: Port, name: str) -> _Statement:
        if port.kind in _ADD:
            add, place = _ADD[port.kind], [port.name]
        else:
            add, place = _ADD_SERVICE[port.kind], [port.port, port.instance]
        type_ = self._imports.type_name(self._declaration(port).name)
        arguments = ", ".join((*map(string_literal, place), type_))
        text = f"self.{name} = self.{add}({arguments})"
        return _Statement(text, docstring(with_unit(port.doc, port.unit), 8))

    def _declaration(self, port: Port) -> Declaration:
        type_ = self._model.unalias(port.type)
        assert isinstance(type_, NamedType), "checked before anything is emitted"
        return self._model.find(type_.name)

    # The profile.

    def _profile(self, attributes: Attributes) -> str:
        component = self._component
        ports = [self._port_profile(port, name) for port, name in attributes.ports]
        parameters = [
            self._parameter_profile(p, name) for p, name in attributes.configuration
        ]
        return _call(
            "ComponentProfile",
            type_name=string_literal(component.name[-1]),
            kind=string_literal(component.kind),
            category=string_literal(component.category),
            vendor=string_literal(component.vendor),
            version=string_literal(component.version),
            description=string_literal(summary(component)),
            rate=number_literal(float(component.rate)),
            max_instances=str(component.max_instances),
            activity=string_literal(component.activity),
            activity_type=_optional(component.activity_type),
            execution=string_literal(component.execution),
            ports=_tuple(ports),
            configuration=_tuple(parameters),
        )

    def _port_profile(self, port: Port, name: str) -> str:
        type_ = self._imports.type_name(self._declaration(port).name)
        return port_profile(port, name, type_)

    def _parameter_profile(self, parameter: ConfigurationParameter, name: str) -> str:
        constraint = parse(parameter.constraint)
        return _call(
            "ParameterProfile",
            name=string_literal(parameter.name),
            python_name=string_literal(name),
            type=string_literal(self._parameters.canonical_type(parameter.type)),
            default=string_literal(self._parameters.default_text(parameter)),
            minimum=_bound(parameter.minimum),
            maximum=_bound(parameter.maximum),
            unit=_optional(parameter.unit),
            constraint=_optional("" if constraint is None else text_of(constraint)),
            widget=_optional(parameter.widget),
            description=_optional(_first_line(parameter.doc)),
        )


def port_profile(port: Port, attribute: str, type_: str) -> str:
    """The expression for the profile of a port; `type_` is that for its type."""
    function = _PROFILES[port.kind]
    given = [string_literal(port.kind.value), string_literal(port.name), type_]
    doc = string_literal(_first_line(port.doc))
    other = string_literal(attribute)
    if attribute != port.name:
        given += [doc, other]
    elif port.doc:
        given += [doc]
    parts = {"unit": port.unit}
    if port.kind in _ADD_SERVICE:
        own = {"port": port.port, "instance": port.instance}
        parts = {**own, "type_name": port.type_name, **parts}
    given += (
        f"{key}={string_literal(text)}"
        for key, text in parts.items()
        if text and (key in ("type_name", "unit") or text != port.name)
    )
    return f"{function}({', '.join(given)})"


def _call(callee: str, /, **arguments: str) -> str:
    """A call with keyword arguments; empty ones are omitted."""
    return f"{callee}({', '.join(f'{key}={value}' for key, value in arguments.items() if value)})"


def _tuple(items: Sequence[str]) -> str:
    return f"({', '.join(items)},)" if items else ""


def _optional(text: str) -> str:
    return string_literal(text) if text else ""


def _bound(value: ConstantValue | None) -> str:
    return "" if value is None else str(value)


def _first_line(doc: str) -> str:
    return doc.strip().partition("\n")[0].strip()
