"""Which ports a page may connect: what the run allows, and what the judge of connections says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from rtgen.compiler.diagnostics import Diagnostic, Severity, Span
from rtgen.compiler.model import Connection, PortReference
from rtgen.compiler.systems.connections import ALLOWABLE
from rtgen.runtime.system.system import System
from rtgen.tools.running.joins import unit_findings
from rtgen.ui.changes import ports_of
from rtgen.ui.errors import NO_FIT, UNKNOWN, CommandError
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.ui.session import Session

_APART: Final = "the system of this page does not run over CORBA"


def fits(session: Session, address: ui.PortAddress) -> list[ui.Fit]:
    """Return which other ports fit a port, and for the rest the reason why not.

    Raises CommandError, RtcError if there is no such port.
    """
    system, remote = session.system, session.remote
    within = [
        ui.PortAddress(instance=each, port=port)
        for each in system.instances
        for port in port_names(system, each)
    ]
    if address.instance in remote.components:
        if remote.port(address) is None:
            raise CommandError(
                UNKNOWN, f"{address.instance} has no port {address.port!r}"
            )
        obstacles = [
            *((each.port, each.refused) for each in remote.fits(address)),
            *((there, _remote_obstacle(session, there, address)) for there in within),
        ]
    else:
        require_port(system, address.instance, address.port)
        here = address.instance, address.port
        obstacles = [
            (there, _remote_obstacle(session, address, there))
            for there in remote.ports()
        ]
        obstacles += (
            (there, system.obstacle(here, (there.instance, there.port)))
            for there in within
            if there != address
        )
    return [_fit(session, address, *each) for each in obstacles]


def port_names(system: System, instance: str) -> list[str]:
    """Return the names of a component's ports, each once."""
    ports = ports_of(system, instance)
    return [*dict.fromkeys((*ports.data, *ports.service))]


def require_port(system: System, instance: str, port: str) -> None:
    """Raise CommandError or RtcError if the port does not exist."""
    if port not in port_names(system, instance):
        raise CommandError(UNKNOWN, f"{instance} has no port {port!r}")


def require_fitting(session: Session, command: ui.Connect) -> None:
    """Raise CommandError for a connection that the judge refuses; give notice of its warnings.

    A property `rtgen.allow.CODE` of the command, with a reason, allows a finding.
    """
    properties = {each.name: each.text for each in command.properties}
    findings = judged(session, command.source, command.target, properties)
    for finding in findings:
        if finding.severity is Severity.ERROR:
            raise CommandError(NO_FIT, text_of(finding), finding.hint or "")
    for finding in findings:
        hint = f"; {finding.hint}" if finding.hint else ""
        session.notice("warning", "", f"{text_of(finding)}{hint}")


def _fit(
    session: Session, here: ui.PortAddress, there: ui.PortAddress, obstacle: str
) -> ui.Fit:
    """Return the verdict on two ports; the run's reason has more to say of types."""
    for finding in judged(session, here, there, {}):
        if finding.severity is Severity.ERROR and obstacle:
            return ui.Fit(port=there, refused=f"{finding.code}: {obstacle}")
        if finding.severity is Severity.ERROR:
            allow = finding.code if finding.code in ALLOWABLE else ""
            return ui.Fit(port=there, refused=text_of(finding), allow=allow)
    return ui.Fit(port=there, refused=obstacle)


def judged(
    session: Session,
    source: ui.PortAddress,
    target: ui.PortAddress,
    properties: Mapping[str, str],
) -> Sequence[Diagnostic]:
    """Return the findings about a connection of two ports with these properties."""
    types = {each.instance: _type(session, each.instance) for each in (source, target)}
    ends = [PortReference(instance=e.instance, port=e.port) for e in (source, target)]
    findings = session.project.judged(ends[0], ends[1], types, properties)
    system = session.system
    if findings or not types.keys() <= {*system.instances}:
        return findings
    if source.port not in system.component(source.instance).out_ports:
        ends.reverse()
    connection = Connection(
        name="",
        source=ends[0],
        target=ends[1],
        service=False,
        span=Span("", 1, 1, 1, 1),
        properties=tuple(properties.items()),
    )
    return [*unit_findings(system, connection)]


def _type(session: Session, instance: str) -> str:
    if instance in session.remote.components:
        return session.remote.components[instance].type
    if instance in session.system.instances:
        return session.system.component(instance).profile.type_name
    return ""


def text_of(finding: Diagnostic) -> str:
    """Return a finding as pages show it."""
    return f"{finding.code}: {finding.message}"


def _remote_obstacle(
    session: Session, here: ui.PortAddress, there: ui.PortAddress
) -> str:
    """Return why a port of the system does not fit one of another process; empty if it does."""
    if session.own is None:
        return _APART
    component = session.system.component(here.instance)
    ports = [p for p in session.describe.ports(component) if p.name == here.port]
    return session.remote.obstacle(here, ports, there)
