"""Validates a system against the definitions of its components (codes RTC058x)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Rule, Severity, Span
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model import (
    ConfigurationParameter,
    Connection,
    Model,
    NamedType,
    Port,
    PortKind,
    PortReference,
    System,
    SystemComponent,
)
from rtgen.compiler.model.declarations import OPAQUE
from rtgen.compiler.model.system_links import (
    DATA_KINDS,
    Known,
    interfaces,
    service_pairs,
)
from rtgen.compiler.systems import units
from rtgen.compiler.typemap.components.parameters import Parameters, ValueMismatchError
from rtgen.facts import connector_properties, parameter_texts

UNKNOWN_COMPONENT = Rule(
    "RTC0580", "system with a component that is not defined", Severity.ERROR
)
UNKNOWN_PORT = Rule(
    "RTC0581", "connector with a port that is not there", Severity.ERROR
)
PORTS_DIFFER = Rule("RTC0582", "ports that cannot be joined", Severity.ERROR)
UNKNOWN_PROPERTY = Rule("RTC0583", "unknown connector property", Severity.ERROR)
PROPERTY_VALUE = Rule(
    "RTC0584", "connector property with a value that it does not take", Severity.ERROR
)
DATA_TYPE = Rule(
    "RTC0585", "connector declares another type than its ports", Severity.WARNING
)
SYSTEM_PARAMETER = Rule(
    "RTC0586",
    "configuration that the component's definition does not have",
    Severity.ERROR,
)
OTHER_DEFINITION = Rule("RTC0592", "id is not that of the definition", Severity.WARNING)

RULES = (
    UNKNOWN_COMPONENT,
    UNKNOWN_PORT,
    PORTS_DIFFER,
    UNKNOWN_PROPERTY,
    PROPERTY_VALUE,
    DATA_TYPE,
    SYSTEM_PARAMETER,
    OTHER_DEFINITION,
    *units.RULES,
)

_ASCENDING = (Severity.NOTE, Severity.WARNING, Severity.ERROR)
_TYPE_KEY = "dataport.data_type"


def check(system: System, components: Mapping[str, Known]) -> list[Diagnostic]:
    """Return all diagnostics about a system; `components` maps type names to definitions."""
    diagnostics = [*check_properties(system)]
    for c in system.components:
        diagnostics += _component(c, components)
    ends = {
        c.instance: components[c.type]
        for c in system.components
        if c.type in components
    }
    for connection in system.connections:
        if connector_properties.OWN_PORT in dict(connection.properties):
            continue
        if {connection.source.instance, connection.target.instance} <= ends.keys():
            joined = _service if connection.service else _data
            diagnostics += joined(connection, ends)
    return diagnostics


def as_warnings(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics as warnings, for commands that only read and write a system."""
    return [
        replace(f, severity=min(f.severity, Severity.WARNING, key=_ASCENDING.index))
        for f in findings
    ]


def check_properties(system: System) -> Iterator[Diagnostic]:
    """Yield diagnostics about connectors that require no definitions."""
    for connection in system.connections:
        table = (
            connector_properties.SERVICE
            if connection.service
            else connector_properties.STATED_DATA
        )
        for written, text in connection.properties:
            key = written.removeprefix(connector_properties.OVERRIDE)
            is_pair = connection.service and connector_properties.is_pair(key)
            if is_pair or key == connector_properties.OWN_PORT:
                continue
            span = connection.places.get(written, connection.span)
            if key not in table:
                yield from _unknown_property(key, table, span)
                continue
            why = connector_properties.violation(table, key, text)
            if why is not None:
                message = f"`{key}` is {text[:80]!r}; it must be {why}"
                yield PROPERTY_VALUE.at(span, message)
        yield from _subscription(connection)


def _subscription(connection: Connection) -> Iterator[Diagnostic]:
    properties = dict(connection.properties)
    meant = connector_properties.subscriptions(properties)
    if connector_properties.lacks_push_rate(properties):
        key = next(k for k in reversed(meant) if meant[k] == "periodic")
        span = connection.places.get(key, connection.span)
        rate = connector_properties.PUSH_RATE
        message = f"`{key}` is 'periodic', but there is no `{rate}`"
        yield PROPERTY_VALUE.at(span, message, hint="say how often, in Hz")
    if connector_properties.is_contradictory(properties):
        first, second = meant
        span = connection.places.get(first, connection.span)
        message = (
            f"`{first}` is {properties[first].strip()!r}, "
            f"but `{second}` is {properties[second].strip()!r}"
        )
        yield PROPERTY_VALUE.at(span, message, hint="state one of them")


def _unknown_property(
    key: str, table: Mapping[str, object], span: Span
) -> Iterator[Diagnostic]:
    near = nearest(key, table)
    if near is None and connector_properties.is_foreign(key):
        return
    message = f"`{key[:80]}` is not a connector property of OpenRTM"
    yield UNKNOWN_PROPERTY.at(span, message, hint=_guess(near))


def _guess(near: str | None) -> str | None:
    return f"did you mean {near}?" if near else None


def _component(
    c: SystemComponent, components: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    definition = components.get(c.type)
    if definition is None:
        hint = _guess(nearest(c.type, components)) or "give its definition as a source"
        message = f"the component {c.type!r} of {c.instance} is not defined"
        yield UNKNOWN_COMPONENT.at(c.span, message, hint=hint)
        return
    id_ = definition.component.profile_id
    if c.id not in (id_, _dotted(id_)):
        message = f"the id of {c.instance} is {c.id!r}, its definition's {id_!r}"
        yield OTHER_DEFINITION.at(c.span, message)
    parameters = {p.name: p for p in definition.component.configuration}
    reader = Parameters(definition.model)
    for set_id, values in c.parameter_sets:
        for name, text in values:
            span = c.places.get((set_id, name), c.span)
            parameter = parameters.get(name)
            if parameter is None:
                message = f"{c.type} has no parameter {name!r}"
                guess = _guess(nearest(name, parameters))
                yield SYSTEM_PARAMETER.at(span, message, hint=guess)
            elif problem := _value_problem(reader, parameter, text):
                message = f"{c.instance}.{name} cannot be {text[:80]!r}: {problem}"
                yield SYSTEM_PARAMETER.at(span, message)


def _dotted(id_: str) -> str:
    """Return the older form of a component's id, `RTC:vendor.category.type:version`."""
    head, *parts, version = id_.split(":")
    return f"{head}:{'.'.join(parts)}:{version}"


def _value_problem(
    reader: Parameters, parameter: ConfigurationParameter, text: str
) -> str | None:
    """Return the error in the text of one or several numbers; None if it is valid."""
    if not reader.is_number(parameter.type):
        return None
    item = reader.item_type(parameter.type)
    try:
        for part in (
            parameter_texts.items(text)
            if reader.is_sequence(parameter.type)
            else [text]
        ):
            reader.check_value(item, reader.parse_item(item, part))
    except ValueMismatchError as error:
        return str(error)
    return None


def _data(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    source = _data_port(connection.source, ends, PortKind.OUTPORT)
    target = _data_port(connection.target, ends, PortKind.INPORT)
    for port in (source, target):
        if isinstance(port, Diagnostic):
            yield port
    if isinstance(source, Diagnostic) or isinstance(target, Diagnostic):
        return
    types = [
        _repository_id(ends[end.instance].model, port)
        for end, port in ((connection.source, source), (connection.target, target))
    ]
    for end, port in ((connection.source, source), (connection.target, target)):
        if _is_opaque(ends[end.instance].model, port):
            message = f"the type {port.type} of {end} was not found, so it stays opaque"
            yield PORTS_DIFFER.at(end.span or connection.span, message)
            return
    if types[0] != types[1]:
        message = (
            f"{connection.source} has the type {source.type}, "
            f"{connection.target} has {target.type}"
        )
        yield PORTS_DIFFER.at(connection.span, message)
        return
    declared = dict(connection.properties).get(_TYPE_KEY, types[0])
    if declared not in (types[0], str(source.type)):
        span = connection.places.get(_TYPE_KEY, connection.span)
        message = f"the connector declares {declared!r}, its ports have {types[0]!r}"
        yield DATA_TYPE.at(span, message)
    model = ends[connection.source.instance].model
    yield from units.check(connection, source, target, model)


def _data_port(
    end: PortReference, ends: Mapping[str, Known], kind: PortKind
) -> Port | Diagnostic:
    component = ends[end.instance].component
    ports = [p for p in component.ports if p.kind in DATA_KINDS]
    named = [p for p in ports if p.name == end.port]
    for port in named:
        if port.kind is kind:
            return port
    if named:
        message = (
            f"{end} is not an {kind.value}; data goes from an OutPort to an InPort"
        )
        return PORTS_DIFFER.at(end.span, message)
    return _unknown_port(end, [p.name for p in ports if p.kind is kind], "data port")


def _unknown_port(end: PortReference, names: Sequence[str], what: str) -> Diagnostic:
    all_of_them = f"it has {', '.join(dict.fromkeys(names)) or 'none'}"
    hint = _guess(nearest(end.port, names)) or all_of_them
    message = f"{end.instance} has no {what} {end.port!r} for this end"
    return UNKNOWN_PORT.at(end.span, message, hint=hint)


def _repository_id(model: Model, port: Port) -> str:
    type_ = model.unalias(port.type)
    if isinstance(type_, NamedType):
        return model.find(type_.name).repository_id
    return str(type_)


def _is_opaque(model: Model, port: Port) -> bool:
    type_ = model.unalias(port.type)
    return isinstance(type_, NamedType) and any(
        annotation.name == OPAQUE for annotation in model.find(type_.name).annotations
    )


def _service(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    missing = False
    for end in (connection.source, connection.target):
        ports = interfaces(end, ends)
        if not ports:
            names = [p.port for p in ends[end.instance].component.ports if p.port]
            yield _unknown_port(end, names, "service port")
            missing = True
    if missing:
        return
    pairs, lonely = service_pairs(connection, ends)
    if not pairs:
        for end, consumer in lonely:
            message = f"{end}: there is no provider of {consumer.type}"
            yield PORTS_DIFFER.at(end.span or connection.span, message)
        if not lonely:
            message = f"{connection.source} and {connection.target} have no consumer"
            yield PORTS_DIFFER.at(connection.span, message)
