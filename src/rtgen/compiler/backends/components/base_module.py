"""Prints the package of a component: its configuration class and its base class."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import starmap

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.components.imports import Imports
from rtgen.compiler.backends.components.locations import (
    base_location,
    heading,
    imported_from,
    module_path,
    summary,
)
from rtgen.compiler.backends.components.members import Attributes, attributes_of
from rtgen.compiler.backends.kit.python_initial import PythonInitial
from rtgen.compiler.backends.kit.python_module import (
    Import,
    PythonModule,
    python_module,
)
from rtgen.compiler.backends.kit.quoting.python import (
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    ConstantValue,
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
from rtgen.compiler.typemap.components.names import CONFIGURATION_NAMES
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.support import BASE_NAMES, CANOPEN_NAMES
from rtgen.facts.canopen_parameters import COMPONENT_FACTS, SHARED
from rtgen.facts.constraints import parse, text_of
from rtgen.facts.parameter_texts import default_text

_TAKEN = CONFIGURATION_NAMES | BASE_NAMES | {"super", "self", "instance_name", "config"}
_FLOATING = (PrimitiveType(Primitive.FLOAT), PrimitiveType(Primitive.DOUBLE))
_DECLARATIONS = {
    PortKind.INPORT: "inport",
    PortKind.OUTPORT: "outport",
    PortKind.PROVIDER: "provider",
    PortKind.CONSUMER: "consumer",
}
"""The functions of the runtime that declare a port."""
_RUNTIME = "rtgen.runtime"
_DATA = (PortKind.INPORT, PortKind.OUTPORT)
_FACTS: Mapping[str, object] = {
    "kind": "DataFlowComponent",
    "activity": "PERIODIC",
    "activity_type": "",
    "execution": "PeriodicExecutionContext",
    "category": "",
    "vendor": "",
    "version": "",
    "description": "",
    "rate": 0.0,
    "max_instances": 1,
}
"""Facts of a profile, which are printed if they differ from these."""

_INHERITED = {**_FACTS, "version": "1.0.0", **COMPONENT_FACTS}
"""The same for proxies and devices."""


@dataclass(frozen=True, slots=True)
class _Value:
    """The default of a parameter: an expression, the IDL type of that, and its text in profiles."""

    expression: str
    type: str
    text: str


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
    taken |= {name for _, name in attributes_of(component).ports}
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
        shared = SHARED.get(component.configuration_base, ())
        self._inherited = {each.name: each.default for each in shared}
        self._functions: dict[str, str] = {}
        self._hidden: Collection[str] = ()

    def module(self, origin: Sequence[str]) -> PythonModule:
        component = self._component
        attributes = _attributes(self._model, component, self._imports)
        self._hidden = {
            name for _, name in (*attributes.ports, *attributes.configuration)
        }
        title = heading(component)
        runtime_base = self._import(component.runtime_base or f"{_RUNTIME}:Component")
        parameters = self._import(
            component.configuration_base or f"{_RUNTIME}:Configuration"
        )
        declared = {p.name for p, _ in attributes.configuration}
        body = render(
            "components/base.py.j2",
            class_docstring=docstring(component.doc, 4, title),
            name=component.name[-1],
            base=self._base,
            arguments=self._arguments(runtime_base.name),
            configuration=self._configuration if declared else "",
            configuration_base=parameters.name,
            declare=self._function("configuration") if declared else "",
            stated=bool(component.runtime_base),
            fields=[*filter(None, starmap(self._field, attributes.configuration))],
            ports=[*starmap(self._port, attributes.ports)],
        )
        return python_module(
            module_path(self._names.package, component),
            self._options,
            origin,
            title,
            imports=[
                *(Import(_RUNTIME, *each) for each in self._functions.items()),
                *([parameters] if declared else []),
                runtime_base,
                *self._imports.imports(),
            ],
            body=body,
            defines=[self._base, self._configuration],
        )

    def _function(self, name: str) -> str:
        """Return the local name of a function, which no attribute of the classes hides."""
        return self._functions.setdefault(
            name, f"_{name}" if name in self._hidden else name
        )

    def _import(self, place: str) -> Import:
        """Return the import of a class, of the runtime or generated."""
        module, name = imported_from(self._options, place)
        return Import(module, name, name)

    def _arguments(self, runtime_base: str) -> str:
        """Return the bases of the class and the facts of its profile."""
        component = self._component
        facts = {name: getattr(component, name) for name in _FACTS}
        facts |= {"description": summary(component), "rate": float(component.rate)}
        common = _INHERITED if component.runtime_base else _FACTS
        written = [runtime_base, f"type_name={string_literal(component.name[-1])}"]
        for name, value in facts.items():
            if value not in ("", common[name]):
                text = isinstance(value, str)
                literal = string_literal(value) if text else number_literal(value)
                written.append(f"{name}={literal}")
        if component.trigger_ports:
            ports = ", ".join(map(string_literal, component.trigger_ports))
            comma = "," * (len(component.trigger_ports) == 1)
            written.append(f"triggers=({ports}{comma})")
        return ", ".join(written)

    # The configuration class.

    def _field(self, parameter: ConfigurationParameter, name: str) -> str:
        """Return the declaration of a parameter, unsplit if its documentation is one line.

        Of an inherited one, return the default alone, or nothing if that is inherited, too.
        """
        type_ = self._model.unalias(parameter.type)
        annotation = self._imports.mapping.annotation(type_)
        default = self._default(parameter, type_)
        if parameter.name in self._inherited:
            if parameter.default == self._inherited[parameter.name]:
                return ""
            return f"{name}: {annotation} = {default.expression}"
        canonical = self._parameters.canonical_type(parameter.type)
        text = self._parameters.default_text(parameter)
        constraint = parse(parameter.constraint)
        arguments = {
            "name": _other(parameter.name, name),
            "type": _other(canonical, default.type),
            "text": string_literal(text) if text != default.text else "",
            "minimum": _bound(parameter.minimum),
            "maximum": _bound(parameter.maximum),
            "unit": _optional(parameter.unit),
            "constraint": _optional("" if constraint is None else text_of(constraint)),
            "widget": _optional(parameter.widget),
        }
        declared = _declaration(
            self._function("parameter"), default.expression, parameter.doc, arguments
        )
        return f"{name}: {annotation} = {declared}"

    def _default(self, parameter: ConfigurationParameter, type_: Type) -> _Value:
        if isinstance(type_, SequenceType):
            items = [
                self._scalar(item, self._parameters.parse_item(item, text))
                for item in (self._model.unalias(type_.element),)
                for text in self._parameters.default_items(parameter)
            ]
            listed = f"[{', '.join(each.expression for each in items)}]"
            if self._imports.mapping.is_text(type_):
                octets = self._imports.mapping.spell("", "bytes")
                listed = (
                    f"{octets}({listed})" if items else self._initial.expression(type_)
                )
            return _Value(listed, "", ",".join(each.text for each in items))
        if parameter.default is not None:
            return self._scalar(type_, parameter.default)
        text = self._parameters.default_text(parameter)
        return self._scalar(type_, self._parameters.parse_item(type_, text))

    def _scalar(self, type_: Type, value: ConstantValue) -> _Value:
        match value:
            case EnumeratorName(name):
                enum = self._imports.mapping.annotation(type_)
                attribute = self._names.enumerator(name)[1]
                return _Value(f"{enum}.{attribute}", "", attribute)
            case str():
                return _Value(string_literal(value), "string", value)
            case int() | float() if type_ in _FLOATING:
                number = float(value)
                return _Value(number_literal(number), "double", default_text(number))
        type_name = "boolean" if isinstance(value, bool) else "long"
        return _Value(repr(value), type_name, default_text(value))

    # The ports.

    def _port(self, port: Port, name: str) -> str:
        """Return the declaration of a port, unsplit if its documentation is one line."""
        type_ = self._model.unalias(port.type)
        assert isinstance(type_, NamedType), "checked before anything is emitted"
        arguments = {"name": _other(port.name, name)}
        if port.kind not in _DATA:
            arguments |= {
                "port": _other(port.port, port.name),
                "instance": _other(port.instance, port.name),
                "type_name": _optional(port.type_name),
            }
        arguments["unit"] = _optional(port.unit)
        function = self._function(_DECLARATIONS[port.kind])
        interface = self._imports.type_name(self._model.find(type_.name).name)
        return f"{name} = {_declaration(function, interface, port.doc, arguments)}"


def _declaration(
    function: str, first: str, doc: str, arguments: Mapping[str, str]
) -> str:
    """Return a call with the documentation, if there is one, as the second argument."""
    named = [f"{key}={value}" for key, value in arguments.items() if value]
    text = docstring(doc, 8).rstrip("\n")
    if "\n" not in text:
        documentation = [string_literal(doc.strip())] if text else []
        return f"{function}({', '.join([first, *documentation, *named])})"
    lines = [f"        {first},", f"{text},", *(f"        {each}," for each in named)]
    return "\n".join([f"{function}(", *lines, "    )"])


def _other(name: str, usual: str) -> str:
    """Return the literal of a name that is not the usual one."""
    return string_literal(name) if name != usual else ""


def _optional(text: str) -> str:
    return string_literal(text) if text else ""


def _bound(value: ConstantValue | None) -> str:
    return "" if value is None else str(value)
