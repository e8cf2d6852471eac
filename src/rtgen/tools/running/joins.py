"""Connections of a run: what the system allows, and what the profiles of components state."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, Severity, Span
from rtgen.compiler.model import (
    Connection,
    Member,
    Model,
    NamedType,
    Port,
    PortKind,
    Struct,
)
from rtgen.compiler.model.types import PrimitiveType
from rtgen.compiler.systems import units
from rtgen.compiler.systems.connection_rules import PORTS_DIFFER
from rtgen.compiler.systems.connections import allowed
from rtgen.compiler.systems.rules import CONNECTION
from rtgen.compiler.systems.timeline import Connect
from rtgen.facts.connector_properties import ALLOW
from rtgen.facts.primitives import Primitive
from rtgen.tools.kit.member_units import units_of

_NO_SPAN = Span("", 1, 1, 1, 1)


def join(
    system: runtime.System,
    action: Connect,
    span: Span | None,
    warn: Callable[[Diagnostic], None],
) -> None:
    """Connect two ports; those that differ by permission of the system are left out.

    Raises RtcError.
    """
    given = action.properties
    own = {key: text for key, text in given.items() if not key.startswith(ALLOW)}
    source, target = action.source, action.target
    ends = (source.instance, source.port), (target.instance, target.port)
    try:
        system.connect(*ends, own, action.name)
    except (runtime.PortTypeError, runtime.PolarityError) as error:
        reason = given.get(f"{ALLOW}{PORTS_DIFFER.code}", "").strip()
        if not reason:
            raise
        finding = CONNECTION.at(span, f"{error}; it is left out: {reason}")
        warn(replace(finding, severity=Severity.WARNING, hint=None))


def unit_errors(
    system: runtime.System, connection: Connection, warn: Callable[[Diagnostic], None]
) -> Iterator[Diagnostic]:
    """Yield the errors of `unit_findings`; `warn` of the others."""
    for finding in unit_findings(system, connection):
        if finding.severity is Severity.ERROR:
            yield finding
        else:
            warn(finding)


def unit_findings(
    system: runtime.System, connection: Connection
) -> Iterator[Diagnostic]:
    """Yield warnings and errors about the units that the profiles of two components state.

    Their types and interfaces are compared by the runtime. Nothing is said of a port without a
    unit, or in another process.
    """
    ends = [
        _stated(system, end.instance, end.port)
        for end in (connection.source, connection.target)
    ]
    (source, model), (target, _) = ends
    if source is None or target is None:
        return
    properties = dict(connection.properties)
    for finding in units.check(connection, source, target, model, model):
        judged = allowed(replace(finding, related=()), properties)
        if judged.severity is not Severity.NOTE:
            yield judged


def _stated(
    system: runtime.System, instance: str, name: str
) -> tuple[Port | None, Model]:
    """Return a data port that states its unit, and a model of its samples' members."""
    if instance not in system.instances:
        return None, Model()
    component = system.component(instance)
    port = component.out_ports.get(name) or component.in_ports.get(name)
    profiles = component.profile.ports
    unit = next((p.unit for p in profiles if p.name == name and not p.port), "")
    if port is None or not unit:
        return None, Model()
    double = PrimitiveType(Primitive.DOUBLE)
    members = tuple(
        Member(name=".".join(path), type=double, span=_NO_SPAN, doc=f"[{each}]")
        for path, each in units_of(component.profile, port).units.items()
    )
    sample = tuple(port.type._descriptor_.name.split("::"))
    struct = Struct(
        name=sample, repository_id="", members=members, span=_NO_SPAN, file=""
    )
    stated = Port(
        kind=PortKind.OUTPORT,
        name=name,
        identifier=name,
        type=NamedType(sample),
        unit=unit,
        span=_NO_SPAN,
    )
    return stated, Model(declarations=(struct,))
