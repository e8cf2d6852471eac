"""Both ends of a connection of data ports: pushed, pulled, or passed directly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import OpenRTM
import OpenRTM__POA
from omniORB import CORBA, PortableServer

from . import orb
from .buffers import DataPortStatus, RingBuffer
from .properties import Properties
from .publishers import PUBLISHERS
from .values import from_octets, split, to_octets

ANSWERS = {
    DataPortStatus.PORT_OK: OpenRTM.PORT_OK,
    DataPortStatus.BUFFER_FULL: OpenRTM.BUFFER_FULL,
    DataPortStatus.BUFFER_EMPTY: OpenRTM.BUFFER_EMPTY,
    DataPortStatus.BUFFER_TIMEOUT: OpenRTM.BUFFER_TIMEOUT,
}
SENT = {
    OpenRTM.PORT_OK: DataPortStatus.PORT_OK,
    OpenRTM.PORT_ERROR: DataPortStatus.PORT_ERROR,
    OpenRTM.BUFFER_FULL: DataPortStatus.SEND_FULL,
    OpenRTM.BUFFER_TIMEOUT: DataPortStatus.SEND_TIMEOUT,
}
RECEIVED = {
    OpenRTM.PORT_OK: DataPortStatus.PORT_OK,
    OpenRTM.PORT_ERROR: DataPortStatus.PORT_ERROR,
    OpenRTM.BUFFER_EMPTY: DataPortStatus.BUFFER_EMPTY,
    OpenRTM.BUFFER_TIMEOUT: DataPortStatus.BUFFER_TIMEOUT,
}


@dataclass
class ConnectorInfo:
    """Name and settings of a connection; `properties` is the node `dataport`."""

    name: str
    id: str
    ports: list[Any]
    properties: Properties

    @property
    def little_endian(self) -> bool:
        """The first byte order of the list."""
        orders = split(self.properties.getProperty("serializer.cdr.endian", "little"))
        return orders[0].lower() != "big"


class Connector:
    """Common base of both ends."""

    def __init__(self, info: ConnectorInfo) -> None:
        self._info = info

    def profile(self) -> ConnectorInfo:
        return self._info

    def id(self) -> str:
        return self._info.id

    def name(self) -> str:
        return self._info.name

    def directMode(self) -> bool:
        return False

    def disconnect(self) -> int:
        return DataPortStatus.PORT_OK


class Served:
    """A servant that ends with its connector."""

    def __init__(self, servant: PortableServer.Servant) -> None:
        self._oid = orb.poa().activate_object(servant)
        self.reference = orb.poa().id_to_reference(self._oid)

    def close(self) -> None:
        orb.poa().deactivate_object(self._oid)


class InPortCdrServant(OpenRTM__POA.InPortCdr):
    """Puts received octets into a buffer."""

    def __init__(self, buffer: RingBuffer) -> None:
        self._buffer = buffer

    def put(self, data: bytes) -> Any:
        return ANSWERS.get(self._buffer.write(data), OpenRTM.PORT_ERROR)


class OutPortCdrServant(OpenRTM__POA.OutPortCdr):
    """Returns octets from a buffer."""

    def __init__(self, buffer: RingBuffer) -> None:
        self._buffer = buffer

    def get(self) -> tuple[Any, bytes]:
        status, data = self._buffer.read()
        return ANSWERS.get(status, OpenRTM.PORT_ERROR), data or b""


class InPortConnector(Connector):
    """The InPort's end: its buffer, and the decoding of values."""

    def __init__(self, info: ConnectorInfo, like: Any, buffer: RingBuffer) -> None:
        super().__init__(info)
        self._like = like
        self._buffer: Any = buffer
        buffer.init(info.properties.getNode("buffer"))

    def getBuffer(self) -> Any:
        """Return the buffer; None for a connection that has ended."""
        return self._buffer

    def disconnect(self) -> int:
        self._buffer = None
        return super().disconnect()

    def read(self, data: Any = None) -> tuple[int, Any]:
        """Return status and value; the value is `data` if there was none to read."""
        status, octets = self.readBuff()
        if status != DataPortStatus.PORT_OK:
            return status, data
        try:
            value = from_octets(self._like, octets, self._info.little_endian)
        except Exception:
            return DataPortStatus.UNKNOWN_ERROR, data
        return status, value

    def readBuff(self) -> tuple[int, bytes]:
        """Return status and octets."""
        if self._buffer is None:
            return DataPortStatus.PRECONDITION_NOT_MET, b""
        status, octets = self._buffer.read()
        return status, octets


class InPortPushConnector(InPortConnector):
    """An InPort's end that receives octets."""

    def __init__(self, info: ConnectorInfo, like: Any, buffer: RingBuffer) -> None:
        super().__init__(info, like, buffer)
        self._served = Served(InPortCdrServant(self._buffer))

    def reference(self) -> Any:
        return self._served.reference

    def disconnect(self) -> int:
        self._served.close()
        return super().disconnect()


class InPortPullConnector(InPortConnector):
    """An InPort's end that fetches octets by `read`; the buffer stays empty."""

    def __init__(
        self, info: ConnectorInfo, like: Any, buffer: RingBuffer, peer: Any
    ) -> None:
        super().__init__(info, like, buffer)
        self._peer = peer

    def readBuff(self) -> tuple[int, bytes]:
        try:
            status, octets = self._peer.get()
        except CORBA.Exception:
            return DataPortStatus.CONNECTION_LOST, b""
        return RECEIVED.get(status, DataPortStatus.UNKNOWN_ERROR), octets


class OutPortPushConnector(Connector):
    """Sends written values by the subscription type."""

    def __init__(self, info: ConnectorInfo, subscription: str, peer: Any) -> None:
        super().__init__(info)
        self._peer = peer
        self._publisher = PUBLISHERS[subscription](self._send, info.properties)

    def write(self, data: Any) -> int:
        """Write a value; one that cannot be marshalled is rejected without a report."""
        try:
            octets = to_octets(data, self._info.little_endian)
        except Exception:
            return DataPortStatus.UNKNOWN_ERROR
        status: int = self._publisher.write(octets)
        return status

    def _send(self, octets: bytes) -> int:
        try:
            return SENT.get(self._peer.put(octets), DataPortStatus.UNKNOWN_ERROR)
        except CORBA.Exception:
            return DataPortStatus.CONNECTION_LOST

    def disconnect(self) -> int:
        self._publisher.close()
        return super().disconnect()


class OutPortPullConnector(Connector):
    """Stores written values until they are fetched."""

    def __init__(self, info: ConnectorInfo) -> None:
        super().__init__(info)
        self._buffer = RingBuffer(info.properties.getNode("buffer"))
        self._served = Served(OutPortCdrServant(self._buffer))

    def getBuffer(self) -> RingBuffer:
        return self._buffer

    def reference(self) -> Any:
        return self._served.reference

    def write(self, data: Any) -> int:
        try:
            octets = to_octets(data, self._info.little_endian)
        except Exception:
            return DataPortStatus.UNKNOWN_ERROR
        return self._buffer.write(octets)

    def disconnect(self) -> int:
        self._served.close()
        return super().disconnect()


class OutPortDirectConnector(Connector):
    """Passes the value itself to an InPort of the process: both then share it."""

    def __init__(self, info: ConnectorInfo, peer: Any) -> None:
        super().__init__(info)
        self._peer = peer

    def write(self, data: Any) -> int:
        self._peer.write(data)
        return DataPortStatus.PORT_OK
