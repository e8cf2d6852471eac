"""Creates connections of two ports, within the process or to another one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

import msgspec

from rtgen.runtime.errors import PolarityError
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.connectors import ServiceConnector
from rtgen.runtime.services.ports import ServicePort
from rtgen.runtime.services.transports import (
    DataTransport,
    RemoteConnector,
    RemoteDataConnector,
    RemotePort,
    Transport,
)
from rtgen.runtime.system.port_names import cannot_join, kinds, port_names, unknown_port
from rtgen.runtime.timing.guards import Guard

Connector = (
    DataConnector[Any] | RemoteDataConnector | ServiceConnector | RemoteConnector
)
PortAddress = tuple[str, str]


class Joining(msgspec.Struct, eq=False):
    """Creates connections; `here` are the names of the instances of this process."""

    _here: Collection[str]
    _component: Callable[[str], Component]
    _guard: Callable[[], Guard]
    _transport: Transport | None

    def made(
        self,
        source: PortAddress,
        target: PortAddress,
        properties: Mapping[str, str],
        name: str,
    ) -> Connector:
        """Return the unestablished connection of two ports.

        Raises UnknownComponentError, or the ConnectError with the reason why the ports are
        incompatible.
        """
        transport = self._transport
        if transport is not None:
            if source[0] in self._here and target[0] not in self._here:
                return self._between(transport, source, target, properties, name)
            if target[0] in self._here and source[0] not in self._here:
                return self._between(
                    transport, target, source, properties, name, sends=False
                )
        first, second = self._component(source[0]), self._component(target[0])
        ways = (
            (first, source[1], second, target[1]),
            (second, target[1], first, source[1]),
        )
        for writer, sending, reader, receiving in ways:
            out_port = writer.out_ports.get(sending)
            in_port = reader.in_ports.get(receiving)
            if out_port is not None and in_port is not None:
                return DataConnector(name, out_port, in_port, properties, self._guard)
        ends = ServicePort(first, source[1]), ServicePort(second, target[1])
        if all(ends):
            return ServiceConnector(name, *ends, properties, self._transport)
        raise cannot_join(first, source[1], second, target[1])

    def _between(
        self,
        transport: Transport,
        here: PortAddress,
        other: PortAddress,
        properties: Mapping[str, str],
        name: str,
        *,
        sends: bool = True,
    ) -> Connector:
        """Return a connection to another process; `sends` selects one of two data ports.

        It matters only for a component with data ports of both directions.
        """
        component = self._component(here[0])
        there = RemotePort(*other)
        if isinstance(transport, DataTransport):
            out_port = component.out_ports.get(here[1])
            in_port = component.in_ports.get(here[1])
            if out_port is not None and (sends or in_port is None):
                return transport.sending(name, out_port, there, properties)
            if in_port is not None:
                guard = self._guard
                return transport.receiving(name, in_port, there, properties, guard)
        port = ServicePort(component, here[1])
        if port:
            return transport.connector(name, port, there, properties)
        if here[1] not in port_names(component):
            raise unknown_port(component, here[1])
        raise PolarityError(
            f"{'.'.join(here)} cannot be connected with another process: "
            f"it is {kinds(component, here[1])}, and only service ports can"
        )


def instances_of(connector: Connector) -> tuple[str, str]:
    """Return the instances of the two ends of a connection."""
    source, target = connector.source, connector.target
    first = source.owner if isinstance(source, OutPort) else source.instance
    second = target.owner if isinstance(target, InPort) else target.instance
    return first, second
