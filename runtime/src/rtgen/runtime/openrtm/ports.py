"""Connects data ports of OpenRTM to those of a behaviour."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rtgen.facts.connector_properties import EmptyPolicy
from rtgen.runtime.failures import log
from rtgen.runtime.ports.buffers import BufferSettings, RingBuffer
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus

if TYPE_CHECKING:
    from rtgen.runtime.openrtm.conversions import Conversions

_OK = 0
"""`PORT_OK` of OpenRTM's connectors."""

_ENDED = -1
"""A code that connectors never return."""


class Inflow:
    """Reads samples from the connections of OpenRTM's InPort into a behaviour's InPort on demand.

    A sample remains in OpenRTM's buffer until the behaviour reads it, so that lengths and policies
    of the connections apply. All connections are read, not only the first.
    """

    lost = 0
    """Number of lost samples, which OpenRTM does not count."""
    is_fetched = True
    """See `DataConnector`."""

    def __init__(
        self, target: InPort[Any], port: Any, datum: Any, conversions: Conversions
    ) -> None:
        self.buffer: RingBuffer[Any] = RingBuffer(
            BufferSettings(length=1), target._guard
        )
        self.source = self
        self._target = target
        self._port = port
        self._datum = datum
        self._convert = conversions.of
        self._connectors: list[Any] = []
        self._pulled: dict[int, Any] = {}
        self._pulling: tuple[bool, ...] = ()
        self._handed_over = False
        self._next = 0
        target._attach(self)  # type: ignore[arg-type]  # as much of a connector as it needs
        target._feed = self.feed

    def _renew(self, connector: Any) -> None:
        """Hook of an InPort whose buffers changed; no effect here."""

    def feed(self) -> None:
        """Read a sample, if there is one."""
        with self.buffer.guard:
            if self.buffer.samples:
                return
            connectors = self._port.connectors()
            if connectors != self._connectors:
                self._look_at(list(connectors))
            wire = self._pushed()
            sample = self._pull() if wire is None else self._converted(wire)
            if sample is not None:
                self.buffer.write(sample)

    def _look_at(self, connectors: list[Any]) -> None:
        """Cache the settings of the connections, which never change."""
        self._connectors = connectors
        self._next = 0
        self._pulled = {}
        properties = [connector.profile().properties for connector in connectors]
        self._pulling = tuple(
            _word(each, "dataflow_type") == "pull" for each in properties
        )
        self._handed_over |= any(map(_is_direct, properties))
        self.buffer.settings = _reading(properties)

    def _pushed(self) -> Any:
        """Return the next value that was pushed, or passed within the process; None without one."""
        count = len(self._connectors)
        for turn in range(count):
            # Round robin, for fairness between buffers.
            place = (self._next + turn) % count
            if self._pulling[place]:
                continue
            connector = self._connectors[place]
            buffer = connector.getBuffer()
            if buffer is not None and buffer.readable() > 0:
                status, wire = self._read(connector)
                if status == _OK:
                    self._next = place + 1
                    return wire
        if self._handed_over and self._port.isNew():
            return self._port.read()
        return None

    def _pull(self) -> Any:
        """Return the value of a pull connection; None if it is unchanged.

        OpenRTM's OutPort returns its last value repeatedly, without an indication.
        """
        for place, connector in enumerate(self._connectors):
            if not self._pulling[place]:
                continue
            status, wire = self._read(connector)
            if status != _OK:
                continue
            sample = self._converted(wire)
            if sample is not None and sample != self._pulled.get(place):
                self._pulled[place] = sample._snapshot_()
                return sample
        return None

    def _read(self, connector: Any) -> tuple[int, Any]:
        """Return status and value of a connection, which may be ending in another thread."""
        try:
            status, wire = connector.read(self._datum)
        except AttributeError:
            # OpenRTM removes its buffer and its peer without a lock.
            return _ENDED, None
        return int(status), wire

    def _converted(self, wire: Any) -> Any:
        try:
            return self._convert(wire)
        except (ValueError, TypeError, AttributeError, OverflowError) as error:
            log.warning("%s: a sample cannot be taken: %s", self._target, error)
            return None


def _word(properties: Any, key: str) -> str:
    """Return a property of a connection in lower case; empty if it is missing."""
    return str(properties.getProperty(key) or "").strip().lower()


def _is_direct(properties: Any) -> bool:
    """Return whether the value object itself is passed, within a process."""
    return _word(properties, "interface_type") == "direct"


def _reading(properties: Sequence[Any]) -> BufferSettings:
    """Return the policy for reads without new samples, from the first connection."""
    if not properties:
        return BufferSettings(length=1)
    policy = _word(properties[0], "buffer.read.empty_policy")
    timeout = _word(properties[0], "buffer.read.timeout")
    policies = {each.value: each for each in EmptyPolicy}
    try:
        seconds = float(timeout or "1.0")
    except ValueError:
        seconds = 1.0
    return BufferSettings(
        length=1,
        empty_policy=policies.get(policy, EmptyPolicy.READBACK),
        read_timeout=max(seconds, 0.0),
    )


class Outflow:
    """Sends samples of a behaviour through OpenRTM's OutPort.

    A single wire object is filled for each sample, since OpenRTM marshals within `write`. A
    `direct` connection passes the object itself to the receiver, so a new object is made for each
    sample.
    """

    def __init__(
        self,
        source: OutPort[Any],
        port: Any,
        kept: Any,
        conversions: Conversions,
    ) -> None:
        self.target = None
        """Raises ValueError: no InPort of this process."""
        self._source = source
        self._port = port
        self._kept = kept
        self._fill = conversions.fill
        self._make = conversions.to
        self._connectors: list[Any] = []
        self._shares = False
        self._lock = threading.RLock()
        source._attach(self)  # type: ignore[arg-type]  # as much of a connector as it needs

    def short_way(self) -> Callable[[Any], PortStatus]:
        """Return the function that the OutPort calls for each sample."""
        return self.send

    def send(self, value: Any) -> PortStatus:
        """Send a sample; return the status of `OutPort.write`."""
        self._source._checked(value)
        port = self._port
        with self._lock:
            connectors = port.connectors()
            if connectors != self._connectors:
                self._look_at(list(connectors))
            before = self._connectors
            if not before:
                return self._to_nobody()
            if self._shares:
                wire = self._make(value)
            else:
                wire = self._kept
                self._fill(wire, value)
            try:
                if port.write(wire):
                    return PORT_OK
            except AttributeError:
                # OpenRTM removes a connector's profile and publisher without a lock.
                return PortStatus.CONNECTION_LOST
            if len(port.connectors()) < len(before):
                return PortStatus.CONNECTION_LOST
            return self._refusal

    def _look_at(self, connectors: list[Any]) -> None:
        self._connectors = connectors
        properties = [connector.profile().properties for connector in connectors]
        self._shares = any(map(_is_direct, properties))
        waits = any(_word(e, "buffer.write.full_policy") == "block" for e in properties)
        self._refusal = PortStatus.BUFFER_TIMEOUT if waits else PortStatus.BUFFER_FULL

    def _to_nobody(self) -> PortStatus:
        if len(self._source.connectors) > 1:
            return PORT_OK  # a device's OutPort also sends to its bus
        self._source.unsent += 1
        return PortStatus.PRECONDITION_NOT_MET
