"""Judges the connections of systems: kinds, types, interfaces, units and policies of both ends.

Every command that reads, makes or shows a connection asks here. A finding that the connection
allows, by the property `rtgen.allow.CODE` with a reason, becomes a note.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Related, Severity, Span
from rtgen.compiler.frontends.kit.suggestions import guess
from rtgen.compiler.model import (
    Connection,
    Model,
    Port,
    PortKind,
    PortReference,
    System,
)
from rtgen.compiler.model.declarations import OPAQUE
from rtgen.compiler.model.system_links import (
    DATA_KINDS,
    Known,
    definitions_of,
    interfaces,
    service_pairs,
)
from rtgen.compiler.systems import units
from rtgen.compiler.systems.connection_rules import (
    ALLOWED_IN_VAIN,
    DATA_TYPE,
    PORTS_DIFFER,
    PROPERTY_VALUE,
    TWICE,
    UNITS,
    UNKNOWN_PORT,
    UNKNOWN_PROPERTY,
    UNSERVED,
)
from rtgen.facts import connector_properties, ros_qos_words
from rtgen.facts.connector_properties import ALLOW, OVERRIDE, OWN_PORT

ALLOWABLE = {rule.code: rule for rule in (PORTS_DIFFER, DATA_TYPE, *UNITS)}
"""The rules that a connection can allow, by code."""

_TYPE_KEY = "dataport.data_type"


def findings(system: System, components: Mapping[str, Known]) -> Iterator[Diagnostic]:
    """Yield the diagnostics about the connections of a system.

    `components` maps type names to definitions; a connection with an end whose type it lacks is
    judged by its properties alone.
    """
    ends = definitions_of(system, components)
    yield from twice(system)
    for connection in system.connections:
        yield from judged(connection, ends)


def twice(system: System) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each connection whose ports an earlier one joins."""
    joined: dict[object, Connection] = {}
    for connection in system.connections:
        ends: Collection[PortReference] = (connection.source, connection.target)
        if connection.service:
            ends = frozenset(ends)
        earlier = joined.setdefault(ends, connection)
        if earlier is not connection:
            message = f"{connection.source} and {connection.target} are joined twice"
            related = [Related(earlier.span, "the first connector")]
            yield TWICE.at(connection.span, message, related=related)


def unserved(
    system: System,
    links: Iterable[Connection],
    components: Mapping[str, Known],
    calls: Callable[[str, str], bool],
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each service port with consumers that are called, and nothing joins.

    `links` are connections that a timeline makes. `calls` returns whether the behaviour of a
    component type uses a port.
    """
    ends = definitions_of(system, components)
    joined = {
        (end.instance, end.port)
        for connection in (*system.connections, *links)
        for end in (connection.source, connection.target)
    }
    provided = {
        (str(port.type), f"{instance}.{port.port}")
        for instance, known in ends.items()
        for port in known.component.ports
        if port.kind is PortKind.PROVIDER
    }
    for c in system.components:
        consumers: dict[str, Port] = {}
        for port in ends[c.instance].component.ports if c.instance in ends else ():
            if port.kind is PortKind.CONSUMER and (c.instance, port.port) not in joined:
                consumers.setdefault(port.port, port)
        for name, port in consumers.items():
            if not calls(c.type, name):
                continue
            fitting = sorted(p for type_, p in provided if type_ == str(port.type))
            where = f": {' or '.join(fitting)}" if fitting else ""
            yield UNSERVED.at(
                c.span,
                f"{c.instance}.{name} is joined with no provider, so its calls fail",
                hint=f"connect it with a provider of {port.type}{where}",
            )


def judged(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    """Yield the diagnostics about a connection; `ends` maps instances to their definitions."""
    yield from _properties(connection)
    yield from compared(connection, ends)


def compared(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    """Yield the diagnostics about the two ends; none if the definition of one is not known."""
    properties = dict(connection.properties)
    joined = {connection.source.instance, connection.target.instance}
    if OWN_PORT in properties or not joined <= ends.keys():
        return
    judge = _service if connection.service else _data
    codes = set()
    for finding in judge(connection, ends):
        codes.add(finding.code)
        yield allowed(finding, properties)
    for code in ALLOWABLE.keys() - codes:
        if properties.get(f"{ALLOW}{code}", "").strip():
            span = connection.places.get(f"{ALLOW}{code}", connection.span)
            message = f"{connection.source} and {connection.target} have no {code}"
            yield ALLOWED_IN_VAIN.at(span, message, hint="remove the property")


def allowed(finding: Diagnostic, properties: Mapping[str, str]) -> Diagnostic:
    """Return a diagnostic as a note if its connection has a property that allows it."""
    reason = properties.get(f"{ALLOW}{finding.code}", "").strip()
    if not reason or finding.code not in ALLOWABLE:
        return finding
    message = f"{finding.message}; the system allows it: {reason}"
    return replace(finding, severity=Severity.NOTE, message=message, hint=None)


def link(
    source: PortReference,
    target: PortReference,
    properties: Mapping[str, str],
    ends: Mapping[str, Known],
    span: Span,
) -> Connection:
    """Return the connection of two ports, given in either order, as the runtime would make it."""
    kinds = [
        {
            p.kind if p.kind in DATA_KINDS else None
            for p in (
                ends[end.instance].component.ports if end.instance in ends else ()
            )
            if end.port in (p.name if p.kind in DATA_KINDS else p.port,)
        }
        for end in (source, target)
    ]
    if kinds[0] == {PortKind.INPORT} and PortKind.OUTPORT in kinds[1]:
        source, target = target, source
    return Connection(
        name=f"{source}-{target}",
        source=source,
        target=target,
        service=kinds == [{None}, {None}],
        properties=tuple(properties.items()),
        span=span,
    )


def _properties(connection: Connection) -> Iterator[Diagnostic]:
    """Yield the diagnostics that require no definitions."""
    table = (
        connector_properties.SERVICE
        if connection.service
        else connector_properties.stated_data()
    )
    for written, text in connection.properties:
        key = written.removeprefix(OVERRIDE)
        is_pair = connection.service and connector_properties.is_pair(key)
        if is_pair or key == OWN_PORT:
            continue
        span = connection.places.get(written, connection.span)
        if key.startswith(ALLOW):
            yield from _allowance(key, text, span)
            continue
        if key not in table:
            yield from _unknown_property(key, table, span)
            continue
        why = connector_properties.violation(table, key, text)
        if why is not None:
            message = f"`{key}` is {text[:80]!r}; it must be {why}"
            yield PROPERTY_VALUE.at(span, message)
    yield from _subscription(connection)
    if not connection.service:
        stated = dict(connection.properties)
        for key, message, hint in ros_qos_words.problems(stated):
            span = connection.places.get(key, connection.span)
            yield PROPERTY_VALUE.at(span, message, hint=hint)


def _allowance(key: str, text: str, span: Span) -> Iterator[Diagnostic]:
    code = key.removeprefix(ALLOW)
    if code not in ALLOWABLE:
        message = f"`{key[:80]}`: a connector cannot allow that"
        hint = guess(code, ALLOWABLE) or f"it can allow {', '.join(sorted(ALLOWABLE))}"
        yield UNKNOWN_PROPERTY.at(span, message, hint=hint)
    elif not text.strip():
        message = f"`{key}` is empty; it must be the reason"
        yield PROPERTY_VALUE.at(span, message, hint="say why it is right here")


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
    own = [OWN_PORT, *(f"{ALLOW}{code}" for code in ALLOWABLE)]
    is_own = key.startswith("rtgen.")
    hint = guess(key, own if is_own else table)
    if hint is None and not is_own and connector_properties.is_foreign(key):
        return
    of = "rtgen" if is_own else "OpenRTM"
    message = f"`{key[:80]}` is not a connector property of {of}"
    yield UNKNOWN_PROPERTY.at(span, message, hint=hint)


def _data(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    source = _data_port(connection, connection.source, ends, PortKind.OUTPORT)
    target = _data_port(connection, connection.target, ends, PortKind.INPORT)
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
    models = (
        ends[end.instance].model for end in (connection.source, connection.target)
    )
    yield from units.check(connection, source, target, *models)


def _data_port(
    connection: Connection,
    end: PortReference,
    ends: Mapping[str, Known],
    kind: PortKind,
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
        return PORTS_DIFFER.at(end.span or connection.span, message)
    names = [p.name for p in ports if p.kind is kind]
    return _unknown_port(connection, end, names, "data port")


def _unknown_port(
    connection: Connection, end: PortReference, names: Sequence[str], what: str
) -> Diagnostic:
    all_of_them = f"it has {', '.join(dict.fromkeys(names)) or 'none'}"
    hint = guess(end.port, names) or all_of_them
    message = f"{end.instance} has no {what} {end.port!r} for this end"
    return UNKNOWN_PORT.at(end.span or connection.span, message, hint=hint)


def _repository_id(model: Model, port: Port) -> str:
    declared = model.declared(port.type)
    return str(model.unalias(port.type)) if declared is None else declared.repository_id


def _is_opaque(model: Model, port: Port) -> bool:
    declared = model.declared(port.type)
    return declared is not None and declared.annotation(OPAQUE) is not None


def _service(connection: Connection, ends: Mapping[str, Known]) -> Iterator[Diagnostic]:
    missing = False
    for end in (connection.source, connection.target):
        ports = interfaces(end, ends)
        if not ports:
            names = [p.port for p in ends[end.instance].component.ports if p.port]
            yield _unknown_port(connection, end, names, "service port")
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
