"""Back end for RTCBuilder: `RTC.xml`, the RtcProfile of a component, format version 0.3.

Element and attribute order are those of the schema; all content, including dates, comes from the
definition, so the output is deterministic.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec

from rtgen.compiler.backends import Artifact, Emission, Options, Part, parts
from rtgen.compiler.backends.components.checks import check, own_components
from rtgen.compiler.backends.components.locations import (
    package_folder,
    source_of,
    summary,
)
from rtgen.compiler.backends.kit.python_text import header
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.model import (
    Component,
    ConfigurationParameter,
    Model,
    Port,
    PortKind,
)
from rtgen.compiler.model.rtc_profile import EVENT, EVENT_ARGUMENTS, EVENT_PORT
from rtgen.compiler.typemap.components.actions import ACTIONS
from rtgen.compiler.typemap.components.parameters import Parameters
from rtgen.compiler.typemap.profiles import facts as profile_facts
from rtgen.compiler.typemap.profiles.escapes import written
from rtgen.facts.constraints import (
    AllOf,
    AnyOf,
    Between,
    Comparison,
    Constraint,
    ItemConstraints,
    KeyConstraints,
    Operator,
    text_of,
)

_DATA_PORTS = {
    PortKind.INPORT: ("DataInPort", "LEFT"),
    PortKind.OUTPORT: ("DataOutPort", "RIGHT"),
}
_POLARITIES = {PortKind.PROVIDER: "Provided", PortKind.CONSUMER: "Required"}
_COMPARISONS = {
    Operator.EQUAL: "propertyIsEqualTo",
    Operator.LESS: "propertyIsLessThan",
    Operator.GREATER: "propertyIsGreaterThan",
    Operator.LESS_OR_EQUAL: "propertyIsLessThanOrEqualTo",
    Operator.GREATER_OR_EQUAL: "propertyIsGreaterThanOrEqualTo",
}


class _Node(msgspec.Struct, frozen=True):
    """A constraint, nested as in the profile; a leaf has texts, others have children."""

    kind: str
    texts: tuple[str, ...] = ()
    children: tuple[_Node, ...] = ()
    key: str = ""


class _Parameter(msgspec.Struct, frozen=True):
    name: str
    identifier: str
    type: str
    default: str
    unit: str
    doc: str
    widget: str
    constraint: _Node | None
    constraint_text: str
    facts: str


class _DataPort(msgspec.Struct, frozen=True):
    kind: str
    position: str
    name: str
    identifier: str
    type: str
    idl_file: str
    unit: str
    doc: str
    facts: str
    events: tuple[dict[str, str], ...]


class _Interface(msgspec.Struct, frozen=True):
    name: str
    identifier: str
    direction: str
    instance: str
    type: str
    idl_file: str
    doc: str


class _ServicePort(msgspec.Struct, frozen=True):
    name: str
    position: str
    interfaces: tuple[_Interface, ...]
    facts: str


class RtcProfileBackend:
    """Generates the `RTC.xml` of each component."""

    name = "rtc-profile"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the profiles of all packages; none if a component has errors."""
        packages = list(parts(model, options))
        diagnostics = [finding for part in packages for finding in check(part.model)]
        if has_errors(diagnostics):
            return Emission((), diagnostics)
        return Emission(
            [each for part in packages for each in _profiles(part)], diagnostics
        )


BACKEND = RtcProfileBackend()


def _profiles(part: Part) -> Iterator[Artifact]:
    for component in own_components(part.model):
        if part.origin and component.factory and not part.options.tecs_corba:
            continue  # only its own process sees it; OpenRTM has its own copy
        place = part.profiles.get(component.name[-1])
        folder = package_folder(part.options, component)
        yield Artifact(
            path=f"{part.options.folder}/{place}" if place else f"{folder}/RTC.xml",
            text=profile_text(part.model, component, part.options),
            origin=part.origin or (source_of(part.model, component).key,),
        )


def profile_text(model: Model, component: Component, options: Options) -> str:
    """Return the profile of a component without errors, as XML text."""
    parameters = Parameters(model)
    source = source_of(model, component)
    comment = header(options.version, [source.key])
    return render(
        "rtc_profile/RTC.xml.j2",
        header=comment,
        component=component,
        id=component.profile_id,
        name=component.name[-1],
        description=summary(component),
        doc=written(component.doc),
        facts=_property(profile_facts.of_component(model, component)),
        actions=ACTIONS,
        configuration=[_parameter(parameters, p) for p in component.configuration],
        data_ports=[
            _data_port(model, p) for p in component.ports if p.kind in _DATA_PORTS
        ],
        service_ports=_service_ports(model, component),
    )


def _parameter(parameters: Parameters, parameter: ConfigurationParameter) -> _Parameter:
    constraint = parameters.constraint(parameter)
    return _Parameter(
        name=parameter.name,
        identifier=parameter.identifier,
        type=parameters.profile_type(parameter.type),
        default=parameters.default_text(parameter),
        unit=parameter.unit,
        doc=written(parameter.doc),
        widget=parameter.widget or "text",
        constraint=None if constraint is None else _node(constraint),
        constraint_text="" if constraint is None else text_of(constraint),
        facts=_property(profile_facts.of_parameter(parameters, parameter)),
    )


def _node(constraint: Constraint, key: str = "") -> _Node:
    match constraint:
        case Comparison(operator, literal):
            return _Node(_COMPARISONS[operator], (literal,), key=key)
        case Between(lower, upper):
            return _Node("Between", (lower, upper), key=key)
        case AllOf(items):
            return _Node("And", children=tuple(map(_node, items)), key=key)
        case AnyOf(items):
            return _Node("Or", children=tuple(map(_node, items)), key=key)
        case ItemConstraints(units):
            return _Node("ConstraintListType", children=tuple(map(_node, units)))
        case KeyConstraints(pairs):
            nodes = tuple(_node(unit, name) for name, unit in pairs)
            return _Node("ConstraintHashType", children=nodes)


def _data_port(model: Model, port: Port) -> _DataPort:
    kind, position = _DATA_PORTS[port.kind]
    if port.kind is PortKind.INPORT and port.annotation(EVENT_PORT) is not None:
        kind = "EventPort"
    return _DataPort(
        kind=kind,
        position=position,
        name=port.name,
        identifier=port.identifier,
        type=str(port.type),
        idl_file=profile_facts.file_of(model, port),
        unit=port.unit,
        doc=written(port.doc),
        facts=_property(profile_facts.of_port(port)),
        events=tuple(
            {key: str(annotation.get(key) or "") for key in EVENT_ARGUMENTS}
            for annotation in port.annotations
            if annotation.name == EVENT
        ),
    )


def _service_ports(model: Model, component: Component) -> list[_ServicePort]:
    """Return interfaces by service port, in the order of their first ones."""
    return [
        _ServicePort(
            name=name,
            position=(
                "LEFT" if any(p.kind is PortKind.PROVIDER for p in ports) else "RIGHT"
            ),
            interfaces=tuple(_interface(model, port) for port in ports),
            facts=_property(_of_interfaces(ports)),
        )
        for name, ports in profile_facts.by_service_port(component.ports).items()
    ]


def _of_interfaces(ports: Sequence[Port]) -> profile_facts.Facts:
    """Return the facts of a service port's interfaces, by identifier."""
    port_facts = {port.identifier: profile_facts.of_port(port) for port in ports}
    return {identifier: facts for identifier, facts in port_facts.items() if facts}


def _property(facts: profile_facts.Facts) -> str:
    """Return the value of the property; empty for no property."""
    return profile_facts.text_from(facts) if facts else ""


def _interface(model: Model, port: Port) -> _Interface:
    return _Interface(
        name=port.instance,
        identifier=port.identifier,
        direction=_POLARITIES[port.kind],
        instance=port.instance,
        type=port.type_name or str(port.type),
        idl_file=profile_facts.file_of(model, port),
        doc=written(port.doc),
    )
