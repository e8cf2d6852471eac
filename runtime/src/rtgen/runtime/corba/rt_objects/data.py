"""Data connections with OpenRTM's interface type `corba_cdr`: octets of CDR, pushed or pulled."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import omniORB
from omniORB import CORBA

from rtgen.facts.connector_properties import Dataflow, embedded_data
from rtgen.facts.port_fitting import is_same_type
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.corba.faults import is_silent, is_timeout
from rtgen.runtime.corba.orb import MAX_MESSAGE
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import IN_PORT_CDR, OUT_PORT_CDR
from rtgen.runtime.errors import ConnectorPropertyError, PortTypeError
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.buffers import BufferSettings, RingBuffer
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.timing.guards import Guard
from rtgen.runtime.xcdr import decode, encode

INTERFACE_TYPE = "corba_cdr"
DATA_DEFAULTS = {
    "dataport.interface_type": INTERFACE_TYPE,
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "flush",
}
"""Default properties of a connection of data ports."""
_ENDIAN = "dataport.serializer.cdr.endian"
_TYPE = "dataport.data_type"
_SENDERS = ("dataport.subscription_type", "dataport.io_mode", "dataport.publisher.")
"""Properties that only concern the sending end, by prefix."""

DEFAULT_LIMIT = 2 << 20
"""The `giopMaxMsgSize` of omniORB, and so of OpenRTM, unless it is configured [octets]."""
_OVERHEAD = 1 << 10
"""More than a message has besides its sample [octets]."""


class Losses(Protocol):
    """What happens after a failure of one connection."""

    def refused(self, reason: str) -> None:
        """Report a sample that cannot be sent; the connection remains."""

    def lost(self, reason: str, *, silent: bool) -> None:
        """End the connection; `silent`: the other process did not answer in time."""


def explained(error: Any, size: int = 0) -> str:
    """Return why a call failed; `size` is that of its sample [octets]."""
    if size > MAX_MESSAGE - _OVERHEAD:
        return f"a sample of {size} octets; at most {MAX_MESSAGE} are sent"
    if is_timeout(error):
        return "the other process does not answer in time"
    if size > DEFAULT_LIMIT - _OVERHEAD and isinstance(error, CORBA.COMM_FAILURE):
        return (
            f"a sample of {size} octets, probably above giopMaxMsgSize of the other process: "
            f"{DEFAULT_LIMIT} unless its options have -ORBgiopMaxMsgSize (OpenRTM: corba.args "
            "in rtc.conf)"
        )
    if is_silent(error):
        return f"the other process does not answer ({type(error).__name__})"
    return f"{type(error).__name__} ({omniORB.minorCodeToString(error) or error.minor})"


def settings_of(properties: Mapping[str, str], type_: type[DataType]) -> dict[str, str]:
    """Return the properties that a connection interprets."""
    interface = properties.get("dataport.interface_type", INTERFACE_TYPE)
    if interface.strip().lower() != INTERFACE_TYPE:
        raise ConnectorPropertyError(
            f"the interface type is {interface}; it must be {INTERFACE_TYPE}"
        )
    descriptor: Any = type_._descriptor_
    stated = properties.get(_TYPE, descriptor.repository_id).strip()
    if not is_same_type(stated, descriptor.repository_id):
        raise PortTypeError(f"samples of type {stated}, not {descriptor.repository_id}")
    kept = {key: text for key, text in properties.items() if key in embedded_data()}
    kept.pop(_TYPE, None)
    for key in ("dataport.dataflow_type", "dataport.subscription_type"):
        if key in kept:
            kept[key] = kept[key].strip().lower()
    return kept


def is_pull(properties: Mapping[str, str]) -> bool:
    """Return whether the receiving end fetches samples."""
    flow = properties.get("dataport.dataflow_type", Dataflow.PUSH)
    return flow.strip().lower() == Dataflow.PULL


def is_little_endian(properties: Mapping[str, str]) -> bool:
    """Return the byte order of a connection: the first one that it lists."""
    first = properties.get(_ENDIAN, "little").partition(",")[0]
    return first.strip().lower() != "big"


class SentConnector(DataConnector[Any]):
    """A connection from an OutPort of this process, which sends samples to a foreign InPort."""

    def __init__(
        self,
        name: str,
        source: OutPort[Any],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
        objects: Exported,
        reference: Any,
        losses: Losses,
    ) -> None:
        outside: InPort[Any] = InPort(name, source.type)
        super().__init__(
            name, source, outside, settings_of(properties, source.type), guard
        )
        put = _Put(
            self.settings.inport_buffer,
            guard(),
            objects,
            reference,
            losses,
            little=is_little_endian(properties),
        )
        self.buffer = put
        self._put = put
        if self.publisher is not None:
            self.publisher = Publisher(self.settings, put, guard())

    @property
    def failed(self) -> int:
        """Number of samples that the other end has not taken."""
        return self._put.failed

    def abandon(self) -> None:
        """Send nothing from now on."""
        self._put.closed = True

    def send(self, value: Any) -> PortStatus:
        """Marshal and send a sample, or leave its snapshot to the publisher."""
        self.source._checked(value)
        return self._deliver(value if self.publisher is None else self._snapshot(value))

    def short_way(self) -> Callable[[Any], PortStatus]:
        """See `DataConnector`."""
        return self.send


class _Put(RingBuffer[Any]):
    """Buffer of a foreign InPort: each `write` calls `InPortCdr::put`."""

    __slots__ = ("_little", "_losses", "_objects", "_reference", "failed")

    def __init__(
        self,
        settings: BufferSettings,
        guard: Guard,
        objects: Exported,
        reference: Any,
        losses: Losses,
        *,
        little: bool,
    ) -> None:
        super().__init__(settings, guard)
        self._objects = objects
        self._reference = reference
        self._losses = losses
        self._little = little
        self.failed = 0

    def write(self, value: Any) -> PortStatus:
        """Send a sample. Raises CdrError for a value that is not of its type."""
        if self.closed:
            self.failed += 1
            return PortStatus.CONNECTION_LOST
        octets = _octets(value, self._little)
        try:
            status: PortStatus = self._objects.call(
                self._reference, IN_PORT_CDR, "put", octets
            )
        except CORBA.SystemException as error:
            self.failed += 1
            reason = explained(error, len(octets))
            if not is_silent(error):
                self._losses.refused(reason)
                return PortStatus.PORT_ERROR
            self.closed = True
            self._losses.lost(reason, silent=is_timeout(error))
            return PortStatus.CONNECTION_LOST
        if status is not PORT_OK:
            self.failed += 1
        return status


def _octets(value: Any, little_endian: bool) -> bytes:
    """Return a sample as a peer of CORBA expects it, which `to_cdr` does not for ROS 2's types.

    Raises CdrError.
    """
    version = value._descriptor_.representation
    return encode(type(value), value, version, little_endian)


def _value(type_: Any, octets: bytes, little_endian: bool) -> Any:
    """Inverse of `_octets`. Raises CdrError."""
    version = type_._descriptor_.representation
    return decode(type_, octets, version, little_endian)


class Receiver:
    """`InPortCdr`: receives the samples of a connection."""

    def __init__(self, connector: DataConnector[Any], *, little: bool) -> None:
        self._connector = connector
        self._little = little

    def put(self, octets: bytes) -> PortStatus:
        """Process a sample; PORT_ERROR if it cannot be decoded."""
        connector = self._connector
        try:
            value = _value(connector.target.type, octets, self._little)
        except CdrError as error:
            log.warning("%s: a sample cannot be decoded: %s", connector.target, error)
            connector.refused += 1
            return PortStatus.PORT_ERROR
        status = connector.give(value)
        return status if status <= PortStatus.UNKNOWN_ERROR else PortStatus.PORT_ERROR


def received(
    name: str,
    target: InPort[Any],
    properties: Mapping[str, str],
    guard: Callable[[], Guard],
) -> DataConnector[Any]:
    """Return a connection to an InPort here, with its buffers. Raises ConnectError."""
    kept = settings_of(properties, target.type)
    here = {key: text for key, text in kept.items() if not key.startswith(_SENDERS)}
    here["dataport.dataflow_type"] = Dataflow.PUSH
    outside: OutPort[Any] = OutPort(name, target.type)
    return DataConnector(name, outside, target, here, guard)


class Source:
    """`OutPortCdr`: provides the samples of a connection, which are queued at the OutPort."""

    def __init__(
        self,
        name: str,
        source: OutPort[Any],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> None:
        self._little = is_little_endian(properties)
        self._waiting: InPort[Any] = InPort(name, source.type)
        self._waiting._protect(guard())
        kept = settings_of(properties, source.type)
        self.connector = DataConnector(name, source, self._waiting, kept, guard)

    def get(self) -> tuple[PortStatus, bytes]:
        """Return the oldest sample; without one, by the policy, the last one or BUFFER_EMPTY."""
        if not self.connector.connected:
            return PortStatus.PORT_ERROR, b""
        value = self._waiting.read()
        if value is None:
            return PortStatus.BUFFER_EMPTY, b""
        try:
            return PORT_OK, _octets(value, self._little)
        except CdrError as error:
            log.warning("%s: %s", self.connector.source, error)
            return PortStatus.PORT_ERROR, b""


class Pulled(DataConnector[Any]):
    """A connection to an InPort of this process, which fetches from a foreign OutPort on demand.

    OpenRTM returns its last sample repeatedly without an indication, so octets equal to the last
    ones are not a new sample.
    """

    is_fetched = True

    def __init__(
        self,
        name: str,
        target: InPort[Any],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
        objects: Exported,
        reference: Any,
        losses: Losses,
    ) -> None:
        kept = settings_of(properties, target.type)
        outside: OutPort[Any] = OutPort(name, target.type)
        super().__init__(name, outside, target, kept, guard)
        self._objects = objects
        self._reference = reference
        self._losses = losses
        self._little = is_little_endian(properties)
        self._last = b""

    def attach(self) -> None:
        """See `DataConnector`."""
        super().attach()
        self.target._feed = self._next(self.target._feed)

    def detach(self) -> None:
        """See `DataConnector`."""
        super().detach()
        pulled = [c for c in self.target.connectors if isinstance(c, Pulled)]
        self.target._feed = None
        for connector in pulled:
            self.target._feed = connector._next(self.target._feed)

    def abandon(self) -> None:
        """Fetch nothing from now on."""
        self._reference = None

    def _next(self, others: Callable[[], None] | None) -> Callable[[], None]:
        def feed() -> None:
            if others is not None:
                others()
            self._fetch()

        return feed

    def _fetch(self) -> None:
        if not self.connected or self._reference is None:
            return
        try:
            status, octets = self._objects.call(self._reference, OUT_PORT_CDR, "get")
        except CORBA.SystemException as error:
            # OpenRTM-aist-Python cannot marshal its value before there is a sample.
            if not is_silent(error):
                return
            self._reference = None
            self._losses.lost(explained(error), silent=is_timeout(error))
            return
        if status is not PORT_OK or octets == self._last:
            return
        self._last = octets
        try:
            value = _value(self.target.type, octets, self._little)
        except CdrError as error:
            log.warning("%s: a sample cannot be decoded: %s", self.target, error)
            return
        self.give(value)
