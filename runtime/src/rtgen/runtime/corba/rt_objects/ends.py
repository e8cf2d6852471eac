"""Targets of port services: InPorts, OutPorts, and the interfaces of service ports."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rtgen.facts.port_fitting import IN_PORT, OUT_PORT, SERVICE_PORT
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.rt_objects.data import (
    INTERFACE_TYPE,
    Losses,
    Pulled,
    Receiver,
    SentConnector,
    Source,
    is_little_endian,
    is_pull,
    received,
)
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.port_ends import Offer
from rtgen.runtime.corba.rt_objects.services import link, offers, type_names
from rtgen.runtime.corba.rt_objects.wire import (
    IN_PORT_CDR,
    OUT_PORT_CDR,
    PortInterfacePolarity,
    PortInterfaceProfile,
)
from rtgen.runtime.errors import ConnectorPropertyError
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.services.ports import Provider, ServicePort
from rtgen.runtime.system.joining import Connector
from rtgen.runtime.timing.guards import Guard

_IN_IOR = "dataport.corba_cdr.inport_ior"
_OUT_IOR = "dataport.corba_cdr.outport_ior"

PORT_TYPE = "port.port_type"

Guards = Callable[[], Guard]


def port_type(port: InPort[Any] | OutPort[Any] | ServicePort) -> str:
    """Return OpenRTM's word for the kind of a port."""
    match port:
        case InPort():
            return IN_PORT
        case OutPort():
            return OUT_PORT
    return SERVICE_PORT


class DataEnd:
    """A data port: an InPort takes pushed samples, an OutPort provides pulled ones."""

    def __init__(
        self, port: InPort[Any] | OutPort[Any], exported: Exported, guard: Guards
    ) -> None:
        descriptor: Any = port.type._descriptor_
        self.port = port.name
        self.properties = {
            PORT_TYPE: port_type(port),
            "dataport.data_type": descriptor.repository_id,
            "dataport.dataflow_type": "push, pull",
            "dataport.interface_type": INTERFACE_TYPE,
            "dataport.subscription_type": "flush, new, periodic",
        }
        self.interfaces: list[PortInterfaceProfile] = []
        self._port = port
        self._receives = isinstance(port, InPort)
        self._exported = exported
        self._guard = guard

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Offer an `InPortCdr` for pushed samples, an `OutPortCdr` for pulled ones.

        Raises ConnectError.
        """
        if is_pull(properties) is self._receives:
            return Offer({})
        if isinstance(self._port, InPort):
            connector = received(name, self._port, properties, self._guard)
            receiver = Receiver(connector, little=is_little_endian(properties))
            return self._offer(_IN_IOR, IN_PORT_CDR, receiver, connector)
        source = Source(name, self._port, properties, self._guard)
        return self._offer(_OUT_IOR, OUT_PORT_CDR, source, source.connector)

    def _offer(self, key: str, type_: Any, target: Any, connector: Connector) -> Offer:
        reference = self._exported.serve(type_, target)
        withdraw = partial(self._exported.withdraw, reference)
        return Offer({key: self._exported.text(reference)}, connector, withdraw)

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """Return a connection that pulls or pushes at the other end. Raises ConnectError."""
        if is_pull(properties) is not self._receives:
            return None
        reference = _reference(
            self._exported, properties, _OUT_IOR if self._receives else _IN_IOR
        )
        more = properties, self._guard, self._exported, reference, losses
        if isinstance(self._port, InPort):
            return Pulled(name, self._port, *more)
        return SentConnector(name, self._port, *more)

    def has(self, connector: Connector) -> bool:
        """See `End`."""
        return isinstance(connector, DataConnector) and self._port in (
            connector.source,
            connector.target,
        )


class ServiceEnd:
    """A service port; `references` are the objects of its providers."""

    def __init__(
        self,
        port: ServicePort,
        known: str,
        objects: Objects,
        exported: Exported,
        references: Mapping[Provider[Any], Any],
    ) -> None:
        self.port = port.port
        self.properties = {PORT_TYPE: port_type(port)}
        self.interfaces = [
            PortInterfaceProfile(end.instance, type_names(end)[0], side)
            for side, ends in (
                (PortInterfacePolarity.PROVIDED, port.providers),
                (PortInterfacePolarity.REQUIRED, port.consumers),
            )
            for end in ends
        ]
        self._port = port
        self._known = known
        self._objects = objects
        self._exported = exported
        self._iors = {p: exported.text(references[p]) for p in port.providers}

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Offer the providers."""
        return Offer(offers(self._port.instance, self._known, self._iors))

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """Return the connection of the consumers. Raises ConnectError."""
        return link(
            name,
            self._port,
            self._known,
            properties,
            self._objects,
            self._exported,
        )

    def has(self, connector: Connector) -> bool:
        """See `End`."""
        ends = connector.source, connector.target
        place = self._port.instance, self._port.port
        return any(
            isinstance(end, ServicePort) and (end.instance, end.port) == place
            for end in ends
        )


def _reference(exported: Exported, properties: Mapping[str, str], key: str) -> Any:
    reference = exported.reference(properties.get(key, ""))
    if reference is None:
        raise ConnectorPropertyError(f"the other port has set no {key}")
    return reference
