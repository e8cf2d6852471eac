"""InPort and OutPort."""

from __future__ import annotations

import copy
from typing import Any

import RTC
from omniORB import CORBA

from . import orb
from .buffers import DataPortStatus, RingBuffer
from .connectors import (
    Connector,
    ConnectorInfo,
    InPortConnector,
    InPortPullConnector,
    InPortPushConnector,
    OutPortDirectConnector,
    OutPortPullConnector,
    OutPortPushConnector,
)
from .NVUtil import list_of, properties_of
from .ports import PortBase
from .properties import Properties
from .publishers import PUBLISHERS
from .values import split, toBool

INTERFACE_TYPES = "corba_cdr,direct"
DATAFLOW_TYPES = "push,pull"
MARSHALING_TYPES = "cdr"


class DataPortBase(PortBase):
    """A port with a data type; one connector for each connection."""

    PORT_TYPE = ""
    END = ""

    def __init__(self, name: str, value: Any) -> None:
        super().__init__(name)
        self._value = value
        # The type name for listeners.
        self._like = copy.deepcopy(value)
        self._connectors: list[Any] = []
        self._properties = Properties()
        for key, text in (
            ("port.port_type", self.PORT_TYPE),
            ("dataport.data_type", CORBA.id(type(value))),
            ("dataport.subscription_type", "flush,new,periodic"),
            ("dataport.io_mode", "block,nonblock"),
            ("dataport.marshaling_types", MARSHALING_TYPES),
            ("dataport.dataflow_type", DATAFLOW_TYPES),
            ("dataport.interface_type", INTERFACE_TYPES),
        ):
            self.addProperty(key, text)

    def init(self, properties: Properties) -> None:
        """Adopt the port's defaults, `port.inport.<name>.*` or `port.outport.<name>.*`."""
        self._properties.mergeProperties(properties)

    def connectors(self) -> list[Any]:
        return self._connectors

    def _refused(self, profile: Any) -> Any:
        asked = properties_of(profile.properties).getNode("dataport")
        if toBool(asked.getProperty("allow_dup_connection"), "YES", "NO", False):
            return None
        others = [p for p in profile.ports if not p._is_equivalent(self._objref)]
        for connection in self.get_connector_profiles():
            for port in connection.ports:
                if any(port._is_equivalent(other) for other in others):
                    return RTC.PRECONDITION_NOT_MET
        return None

    def _complete(self, profile: Any) -> None:
        given = properties_of(profile.properties)
        if not given.getProperty("dataport.serializer.cdr.endian"):
            given.setProperty("dataport.serializer.cdr.endian", "little,big")
        profile.properties = list_of(given)

    def _info(self, profile: Any, given: dict[str, str]) -> ConnectorInfo | None:
        """Return the settings of this end; None if they are not supported.

        Buffer settings of a connection stay with the port: the next one inherits them.
        """
        tree = Properties()
        for key, text in given.items():
            tree.setProperty(key, text)
        asked = tree.getNode("dataport")
        asked.mergeProperties(asked.getNode(self.END))
        self._properties.getNode("buffer").mergeProperties(asked.getNode("buffer"))
        properties = Properties(self._properties).mergeProperties(asked)
        if (
            properties.getProperty("interface_type") not in split(INTERFACE_TYPES)
            or properties.getProperty("dataflow_type", "push")
            not in split(DATAFLOW_TYPES)
            or properties.getProperty("marshaling_type", "cdr")
            not in split(MARSHALING_TYPES)
        ):
            return None
        return ConnectorInfo(
            profile.name, profile.connector_id, profile.ports, properties
        )

    def _add(self, connector: Connector) -> None:
        with self._lock:
            self._connectors.append(connector)

    def unsubscribeInterfaces(self, profile: Any) -> None:
        ended = [c for c in self._connectors if c.id() == profile.connector_id]
        # They end before they are removed from the list, where a reader may still find them.
        for connector in ended:
            connector.disconnect()
            self._connectors.remove(connector)


def is_pull(info: ConnectorInfo) -> bool:
    return info.properties.getProperty("dataflow_type", "push") == "pull"


def is_direct(info: ConnectorInfo) -> bool:
    return info.properties.getProperty("interface_type") == "direct"


class InPort(DataPortBase):
    """A port whose connectors share one buffer.

    Without a name, `isNew` and `read` use the first connector.
    """

    PORT_TYPE = "DataInPort"
    END = "inport"

    def __init__(self, name: str, value: Any) -> None:
        super().__init__(name, value)
        self._handed_over = False
        self._buffer = RingBuffer(Properties())

    def publishInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        info = self._info(profile, given)
        if info is None:
            return RTC.BAD_PARAMETER
        if is_direct(info):
            self._add(InPortConnector(info, self._value, self._buffer))
        elif not is_pull(info):
            connector = InPortPushConnector(info, self._value, self._buffer)
            self._add(connector)
            given["dataport.corba_cdr.inport_ior"] = orb.to_text(connector.reference())
        return RTC.RTC_OK

    def subscribeInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        info = self._info(profile, given)
        if info is None:
            return RTC.BAD_PARAMETER
        if is_pull(info) and not is_direct(info):
            text = given.get("dataport.corba_cdr.outport_ior")
            if not text:
                return RTC.RTC_ERROR
            peer = orb.from_text(text)
            self._add(InPortPullConnector(info, self._value, self._buffer, peer))
        return RTC.RTC_OK

    def isNew(self, names: Any = None) -> bool:
        """Return whether the first connector, or the named one, has unread data.

        A list is filled with the names of all connectors that have unread data.
        """
        with self._lock:
            if self._handed_over:
                return True
            connectors = list(self._connectors)
        if isinstance(names, list):
            names[:] = [c.name() for c in connectors if c.getBuffer().readable()]
            return bool(names)
        if isinstance(names, str):
            connectors = [c for c in connectors if c.name() == names]
        return bool(connectors and connectors[0].getBuffer().readable())

    def isEmpty(self, names: Any = None) -> bool:
        return not self.isNew(names)

    def read(self, name: str | None = None) -> Any:
        """Return the oldest unread value; the last one if there is none."""
        with self._lock:
            if self._handed_over:
                self._handed_over = False
                return self._value
            connectors = [
                c for c in self._connectors if name is None or c.name() == name
            ]
        if connectors:
            status, value = connectors[0].read(self._value)
            if status == DataPortStatus.PORT_OK:
                self._value = value
        return self._value

    def write(self, data: Any) -> None:
        """Store the value itself, from an OutPort in the process."""
        with self._lock:
            self._value = data
            self._handed_over = True


class OutPort(DataPortBase):
    """Writes to every connector."""

    PORT_TYPE = "DataOutPort"
    END = "outport"

    def publishInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        info = self._info(profile, given)
        if info is None:
            return RTC.BAD_PARAMETER
        if is_pull(info) and not is_direct(info):
            connector = OutPortPullConnector(info)
            self._add(connector)
            given["dataport.corba_cdr.outport_ior"] = orb.to_text(connector.reference())
        return RTC.RTC_OK

    def subscribeInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        info = self._info(profile, given)
        if info is None:
            return RTC.BAD_PARAMETER
        if is_direct(info):
            peer = self._peer(profile)
            if peer is None:
                return RTC.RTC_ERROR
            self._add(OutPortDirectConnector(info, peer))
        elif not is_pull(info):
            text = given.get("dataport.corba_cdr.inport_ior")
            asked = info.properties.getProperty
            subscription = asked("io_mode") or asked("subscription_type", "flush")
            subscription = subscription.strip().lower()
            if not text or subscription not in PUBLISHERS:
                return RTC.RTC_ERROR
            self._add(OutPortPushConnector(info, subscription, orb.from_text(text)))
        return RTC.RTC_OK

    def _peer(self, profile: Any) -> InPort | None:
        """Return the InPort of the profile, if it lives in this process."""
        for port in profile.ports:
            servant = orb.local(port)
            if isinstance(servant, InPort):
                return servant
        return None

    def write(self, value: Any = None) -> bool:
        """Send a value, by default the bound one; False if a connector failed."""
        if value is None:
            value = self._value
        with self._lock:
            connectors = list(self._connectors)
        taken = bool(connectors)
        for connector in connectors:
            status = connector.write(value)
            if status != DataPortStatus.PORT_OK:
                taken = False
            if status == DataPortStatus.CONNECTION_LOST:
                self.disconnect(connector.id())
        return taken
