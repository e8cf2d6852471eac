"""Names of ports in messages, and reasons why two ports cannot be connected."""

from __future__ import annotations

from rtgen.runtime.errors import ConnectError, PolarityError, UnknownPortError
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import ServicePort


def cannot_join(
    source: Component, port: str, target: Component, other: str
) -> ConnectError:
    """Return the reason why two ports cannot be connected in either direction."""
    for component, name in ((source, port), (target, other)):
        if name not in port_names(component):
            return unknown_port(component, name)
    ends = f"{source.instance_name}.{port} and {target.instance_name}.{other}"
    pair = f"{kinds(source, port)} and {kinds(target, other)}"
    return PolarityError(
        f"{ends} cannot be connected: they are {pair}; "
        "an OutPort goes with an InPort, a service port with a service port"
    )


def unknown_port(component: Component, name: str) -> UnknownPortError:
    """Return the error for an unknown port of a component."""
    names = ", ".join(port_names(component)) or "none"
    return UnknownPortError(
        f"{component.instance_name} has no port {name!r}; known: {names}"
    )


def port_names(component: Component) -> tuple[str, ...]:
    """Return the names of a component's ports."""
    services = [port for port, _ in (*component.providers, *component.consumers)]
    return tuple(dict.fromkeys([*component.in_ports, *component.out_ports, *services]))


def kinds(component: Component, port: str) -> str:
    """Return the kinds of ports that a component has under a name."""
    kinds = {
        "InPort": port in component.in_ports,
        "OutPort": port in component.out_ports,
        "service port": bool(ServicePort(component, port)),
    }
    return " and ".join(kind for kind, is_there in kinds.items() if is_there)
