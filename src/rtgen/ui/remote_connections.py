"""Connections of pages to ports of other processes: samples received and sent, services called.

These ports belong to no component and are not in a naming service. A connection is make_ends when a
page needs it, and ends after some seconds without use.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from rtgen import runtime
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.data import Losses, is_little_endian
from rtgen.runtime.corba.rt_objects.ends import DataEnd, ServiceEnd
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.port_ends import End, Offer
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import (
    IN_PORT_CDR,
    ConnectorProfile,
    PortInterfaceProfile,
    PortProfile,
    texts,
    values,
)
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import PORT_OK, RTC_OK, PortStatus
from rtgen.runtime.services.ports import Consumer, ServicePort
from rtgen.runtime.services.servants import Invoker, Servant
from rtgen.runtime.system.joining import Connector
from rtgen.ui.errors import CALL_FAILED, CommandError
from rtgen.ui.watching import Key, Take, Use

PAGE: Final = "rtgen_ui"
"""The instance name of ports of pages, as seen by other processes."""
IDLE: Final = 5.0
"""Lifetime of an unused connection [s]."""
_IN_IOR: Final = "dataport.corba_cdr.inport_ior"
_BIG, _LITTLE = b"\0\0\0\0", b"\0\1\0\0"
"""The encapsulation headers of classic CDR."""
_NEWEST: Final = {
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "new",
    "dataport.publisher.push_policy": "new",
}
"""Properties by which the writer does not wait, and only its newest sample is sent."""
_AT_ONCE: Final = _NEWEST | {"dataport.subscription_type": "flush"}


class _InEnd:
    """An InPort that forwards samples."""

    def __init__(self, name: str, type_: str, exported: Exported, take: Take) -> None:
        self.port = name
        self.properties = {
            "port.port_type": "DataInPort",
            "dataport.data_type": type_,
            "dataport.dataflow_type": "push",
            "dataport.interface_type": "corba_cdr",
            "dataport.subscription_type": "flush, new, periodic",
        }
        self.interfaces: list[PortInterfaceProfile] = []
        self._exported = exported
        self._take = take
        self._header = _LITTLE

    def offer(self, name: str, properties: Mapping[str, str]) -> Offer:
        """Return an `InPortCdr`."""
        self._header = _LITTLE if is_little_endian(properties) else _BIG
        reference = self._exported.serve(IN_PORT_CDR, self)
        withdraw = partial(self._exported.withdraw, reference)
        return Offer({_IN_IOR: self._exported.text(reference)}, None, withdraw)

    def accept(
        self, name: str, properties: Mapping[str, str], losses: Losses
    ) -> Connector | None:
        """See `End`; there is nothing to do after `offer`."""
        return None

    def has(self, connector: Connector) -> bool:
        """See `End`."""
        return False

    def put(self, octets: bytes) -> PortStatus:
        """See `InPortCdr`."""
        self._take(self._header + octets)
        return PORT_OK


class _Owner(runtime.Component):
    """Owner of the consumers of pages; belongs to no system."""

    profile = runtime.ComponentProfile(PAGE)


@dataclass(eq=False)
class _Connection:
    """A connection to a port of another process. `tool`: the end for samples or calls."""

    here: PortService
    there: Any
    connector: str
    tool: Any
    make_ends: float = field(default_factory=time.monotonic)
    used: float = field(default_factory=time.monotonic)


class RemoteConnections:
    """The connections of pages; everything except receiving samples is done in one thread.

    Methods raise CommandError and the exceptions of omniORB.
    """

    def __init__(self, orb: Orb, exported: Exported) -> None:
        self.exported = exported
        self.system: runtime.System | None = runtime.System(runtime.RealClock())
        self.ids: dict[str, str] = {}
        self._objects = Objects(orb)
        self._lines: dict[Key, _Connection] = {}

    def at(self, connector: Connector) -> list[PortService]:
        """See `Ports`; connections of pages end at one of them alone."""
        return []

    def give_up(self, place: str, reason: str) -> None:
        """See `Ports`; the thread that polls components ends these connections."""

    def close(self, patience: float) -> None:
        """End the connections, if other processes answer within that time [s]."""
        end = time.monotonic() + patience
        while self._lines and time.monotonic() < end:
            self.end(next(iter(self._lines)))
        if self.system is not None:
            self.system.close()

    def end(self, key: Key) -> None:
        """End a connection."""
        line = self._lines.pop(key)
        line.here.disconnect(line.connector)
        line.here.close()

    def tidy(
        self,
        keys: Container[Key],
        seen: Callable[[str, str], tuple[PortProfile | None, float]],
    ) -> None:
        """End the unused connections.

        `keys`: the watched ones. `seen`: the last known state of a port, and its time.
        """
        now = time.monotonic()
        for key, line in [*self._lines.items()]:
            port, when = seen(key.instance, key.port)
            is_needed = key in keys if key.use is Use.LISTEN else line.used > now - IDLE
            if (
                not is_needed
                or port is None
                or not port.port_ref._is_equivalent(line.there)
                or (when > line.make_ends and not _has(port, line.connector))
            ):
                self.end(key)

    def listen(self, key: Key, port: PortProfile, take: Take) -> None:
        """Receive the samples of an OutPort from now on."""
        type_ = _type_of(port)
        properties = _NEWEST | {"dataport.data_type": type_}

        def make_ends() -> tuple[End, Any]:
            return _InEnd(key.port, type_, self.exported, take), None

        self._line(key, port, make_ends, properties, first=False)

    def give(self, key: Key, port: PortProfile, value: DataType) -> None:
        """Send a sample to an InPort."""
        properties = _AT_ONCE | {"dataport.data_type": _type_of(port)}

        def make_ends() -> tuple[End, Any]:
            outlet: OutPort[Any] = OutPort(key.port, type(value), PAGE)
            return DataEnd(outlet, self.exported, self._guard), outlet

        self._line(key, port, make_ends, properties, first=True).tool.write(value)

    def caller(
        self, key: Key, port: PortProfile, interface: type[Servant], type_name: str
    ) -> Invoker:
        """Return an invoker of an interface that a port provides under the name of a type."""

        def make_ends() -> tuple[End, Any]:
            owner = _Owner(PAGE)
            consumer = Consumer(
                key.port, key.interface, interface, PAGE, type_name=type_name
            )
            owner.consumers[key.port, key.interface] = consumer
            service = ServicePort(owner, key.port)
            end = ServiceEnd(service, key.port, self._objects, self.exported, {})
            return end, consumer

        consumer: Consumer[Any] = self._line(key, port, make_ends, {}, first=True).tool
        if not consumer.connected:
            self.end(key)
            raise CommandError(CALL_FAILED, f"{port.name} offers no {type_name}")
        return consumer._call

    def _guard(self) -> Any:
        assert self.system is not None
        return self.system.clock.guard()

    def _line(
        self,
        key: Key,
        port: PortProfile,
        make_ends: Callable[[], tuple[End, Any]],
        properties: Mapping[str, str],
        *,
        first: bool,
    ) -> _Connection:
        """Return the connection to a port, created if missing. `first`: it begins at this end."""
        line = self._lines.get(key)
        if line is None:
            end, tool = make_ends()
            here = PortService(self, PAGE, end.port, end)
            ends = [here.reference, port.port_ref]
            asked = ConnectorProfile(
                f"{PAGE}_{port.name}",
                "",
                ends if first else ends[::-1],
                values(properties),
            )
            code, profile = here.connect(asked)
            if code is not RTC_OK:
                here.close()
                raise CommandError(CALL_FAILED, f"{port.name} refuses: {code.name}")
            line = _Connection(here, port.port_ref, profile.connector_id, tool)
            self._lines[key] = line
        line.used = time.monotonic()
        return line


def _type_of(port: PortProfile) -> str:
    return texts(port.properties).get("dataport.data_type", "")


def _has(port: PortProfile, connector: str) -> bool:
    return any(each.connector_id == connector for each in port.connector_profiles)
