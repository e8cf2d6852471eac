"""Rates at which the components of a system write to the proxies of a bus."""

from __future__ import annotations

from collections.abc import Mapping

from rtgen.compiler.layouts.can_messages import Writing
from rtgen.compiler.model import Connection, System, SystemComponent
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import PdoDirection
from rtgen.compiler.typemap.canopen.ports import DevicePorts

_RATE = 1000.0
"""Default rate in Hz of an execution context, as `rtgen run` uses."""


def writings(bus: Bus, system: System) -> dict[tuple[str, int], Writing]:
    """Return the write rates of the RPDOs that a system's components write, by node and number.

    A writer counts as one sample for each tick of its context, or of its connector if that is
    periodic. Samples wait for the next tick of the proxy.
    """
    components = {c.instance: c for c in system.components}
    writings_of: dict[tuple[str, int], Writing] = {}
    for node in bus.nodes:
        for proxy in system.components:
            if not _stands_for(proxy, node, bus):
                continue
            for pdo, ports in _in_ports(node).items():
                rate = sum(
                    _rate(connection, components)
                    for connection in system.connections
                    if connection.target.instance == proxy.instance
                    and connection.target.port in ports
                )
                if rate:
                    wait = 1 / (proxy.rate or _RATE)
                    writings_of[node.name, pdo] = Writing(1 / rate, wait)
    return writings_of


def has_proxies(bus: Bus, system: System) -> bool:
    """Return whether a component of the system stands for a node of the bus."""
    return any(_stands_for(c, n, bus) for c in system.components for n in bus.nodes)


def _stands_for(proxy: SystemComponent, node: BusNode, bus: Bus) -> bool:
    if proxy.type != f"{node.kind.module}Proxy":
        return False
    parameters = dict(dict(proxy.configuration).get(proxy.active_set, ()))
    first = next(n.id for n in bus.nodes if n.kind.module == node.kind.module)
    return parameters.get("network", bus.name) == bus.name and parameters.get(
        "node_id", str(first)
    ) == str(node.id)


def _in_ports(node: BusNode) -> dict[int, set[str]]:
    """Return the InPorts that feed each RPDO."""
    ports = DevicePorts(node.device, node.kind)
    if not ports.per_object:
        return {s.pdo.number: {s.name} for s in ports.of(PdoDirection.RPDO)}
    by_node: dict[int, set[str]] = {}
    for port in ports.object_ports:
        if port.direction is PdoDirection.RPDO:
            for pdo, _ in port.places:
                by_node.setdefault(pdo, set()).add(port.name)
    return by_node


def _rate(connection: Connection, components: Mapping[str, SystemComponent]) -> float:
    """Return the rate of a connection in Hz; 0 if its writer is not part of the system."""
    writer = components.get(connection.source.instance)
    if writer is None:
        return 0.0
    rate = writer.rate or _RATE
    properties = dict(connection.properties)
    if properties.get("dataport.subscription_type") == "periodic":
        try:
            return min(rate, float(properties.get("dataport.push_rate", "")))
        except ValueError:
            return rate
    return rate
