"""Targets of port services: InPorts, OutPorts, and the interfaces of service ports."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

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

Guards = Callable[[], Guard]


def _data_properties(kind: str, port: InPort[Any] | OutPort[Any]) -> dict[str, str]:
    descriptor: Any = port.type._descriptor_
    return {
        "port.port_type": kind,
        "dataport.data_type": descriptor.repository_id,
        "dataport.dataflow_type": "push, pull",
        "dataport.interface_type": INTERFACE_TYPE,
        "dataport.subscription_type": "flush, new, periodic",
    }


class InEnd:
    """An InPort."""

    def __init__(self, port: InPort[Any], exported: Exported, guard: Guards) -> None:
        self.port = port.name
        self.properties = _data_properties("DataInPort", port)
        self.interfaces: list[PortInterfaceProfile] = []
        self._port = port
        self._exported = exported
        self._guard = guard

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Offer an `InPortCdr` for pushed samples. Raises ConnectError."""
        if is_pull(properties):
            return Offer({})
        connector = received(name, self._port, properties, self._guard)
        receiver = Receiver(connector, little=is_little_endian(properties))
        reference = self._exported.serve(IN_PORT_CDR, receiver)
        withdraw = partial(self._exported.withdraw, reference)
        return Offer({_IN_IOR: self._exported.text(reference)}, connector, withdraw)

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """Return a connection to the other end for pulled samples. Raises ConnectError."""
        if not is_pull(properties):
            return None
        reference = _reference(self._exported, properties, _OUT_IOR)
        return Pulled(
            name, self._port, properties, self._guard, self._exported, reference, losses
        )

    def has(self, connector: Connector) -> bool:
        """See `End`."""
        return isinstance(connector, DataConnector) and connector.target is self._port


class OutEnd:
    """An OutPort."""

    def __init__(self, port: OutPort[Any], exported: Exported, guard: Guards) -> None:
        self.port = port.name
        self.properties = _data_properties("DataOutPort", port)
        self.interfaces: list[PortInterfaceProfile] = []
        self._port = port
        self._exported = exported
        self._guard = guard

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Offer an `OutPortCdr` for pulled samples. Raises ConnectError."""
        if not is_pull(properties):
            return Offer({})
        source = Source(name, self._port, properties, self._guard)
        reference = self._exported.serve(OUT_PORT_CDR, source)
        withdraw = partial(self._exported.withdraw, reference)
        ior = self._exported.text(reference)
        return Offer({_OUT_IOR: ior}, source.connector, withdraw)

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """Return a connection to the other end for pushed samples. Raises ConnectError."""
        if is_pull(properties):
            return None
        reference = _reference(self._exported, properties, _IN_IOR)
        return SentConnector(
            name, self._port, properties, self._guard, self._exported, reference, losses
        )

    def has(self, connector: Connector) -> bool:
        """See `End`."""
        return isinstance(connector, DataConnector) and connector.source is self._port


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
        self.properties = {"port.port_type": "CorbaPort"}
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
