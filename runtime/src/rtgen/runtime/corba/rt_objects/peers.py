"""Connections to components of other processes, rtgen's or OpenRTM's, found by name."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rtgen.facts.connector_properties import STRICTNESS
from rtgen.facts.openrtm_ports import RUNTIME, known_name
from rtgen.facts.port_fitting import is_same_type
from rtgen.runtime.corba.naming import is_alive
from rtgen.runtime.corba.rt_objects.data import (
    DATA_DEFAULTS,
    DEFAULT_LIMIT,
    SentConnector,
)
from rtgen.runtime.corba.rt_objects.foreign import Directory
from rtgen.runtime.corba.rt_objects.remote import FAULTS, RemoteRtc
from rtgen.runtime.corba.rt_objects.services import type_names
from rtgen.runtime.corba.rt_objects.wire import (
    ConnectorProfile,
    PortInterfacePolarity,
    PortProfile,
    texts,
    values,
)
from rtgen.runtime.errors import PortTypeError, TransportError
from rtgen.runtime.failures import NOTE, log
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import RTC_OK, ReturnCode_t
from rtgen.runtime.services.ports import ServicePort
from rtgen.runtime.services.transports import LinkReport, RemotePort
from rtgen.runtime.system.joining import Connector

if TYPE_CHECKING:
    from rtgen.runtime.corba.rt_objects.ports import PortService
    from rtgen.runtime.corba.rt_objects.publishing import RtObjects

_POLL_INTERVAL = 0.05
_FIRST_DELAY, _MAX_DELAY = 0.25, 10.0
"""First and longest delay before a connection ended by the other component is made again [s]."""


class _Peer:
    """A connection between a port of this process and one of another, made by `establish`."""

    suffix = ""
    """Possible suffix of OpenRTM's name of the other port; see `registered_names`."""

    def __init__(
        self,
        name: str,
        here: InPort[Any] | OutPort[Any] | ServicePort,
        there: RemotePort,
        properties: Mapping[str, str],
        objects: RtObjects,
    ) -> None:
        self.name = name
        self.here = here
        self.there = there
        self._sends = isinstance(here, OutPort)
        receives = isinstance(here, InPort)
        ends: tuple[Any, Any] = (there, here) if receives else (here, there)
        self.source, self.target = ends
        self.kind = (
            "DataInPort" if self._sends else "DataOutPort" if receives else "CorbaPort"
        )
        """The type of the other port."""
        self.properties = dict(properties)
        self.connected = False
        self._objects = objects
        self._component: Any = None
        self._is_rtgen = False
        self._made = 0.0
        """When the connection was made last, by `time.monotonic`; 0 before."""
        self._ended = False
        """Whether the other component has ended it, and it is to be made again."""
        self._in_doubt = False
        """Whether a component of rtgen has ended it, perhaps on purpose."""
        self._delay = _FIRST_DELAY
        self._due = 0.0
        self._failed = 0
        """Samples not taken by the other end of former connections."""
        self._not_received = 0
        self._breaks = 0
        self._renewals = 0
        self._reason = ""

    def __str__(self) -> str:
        return f"{self.name} ({self.source} to {self.target})"

    def attach(self) -> None:
        """Do nothing: `establish` makes the connection."""
        self.connected = True

    def detach(self) -> None:
        """Remove the connection at both ends."""
        self.connected = False
        self._component = None
        port = self._objects.port(self.here)
        if port is not None:
            port.leave(self.name)

    def establish(self, directory: Directory, deadline: float) -> None:
        """Make the connection, waiting for the other component.

        Raises TransportError after a time of `time.monotonic`, PortTypeError if the other port is
        missing, has another type, or refuses.
        """
        while not self.attempt(directory):
            if time.monotonic() > deadline:
                where = directory.where(self.there.instance)
                raise TransportError(f"{self.here} waits for {self.there}; {where}")
            time.sleep(_POLL_INTERVAL)

    def attempt(self, directory: Directory) -> bool:
        """Make the connection; False if the other component is missing.

        Does nothing if the connection exists. Raises TransportError, PortTypeError.
        """
        port = self._objects.port(self.here)
        component = None if port is None else directory.find(self.there.instance)
        if port is None or component is None:
            return False
        try:
            profile = RemoteRtc(component, self._objects.exported).read_profile()
        except FAULTS:
            return False
        other = self._port_of(profile)
        self._is_rtgen = RUNTIME in texts(profile.properties)
        port.watch(self.name, self)
        if port.has_link(self.name, other):
            self._component = component
            self._ended = self._in_doubt = False
            return True
        is_known = self._is_known(component)
        is_lost = is_known and port.has_lost(self.name)
        if is_known and self._in_doubt and not is_lost:
            try:
                is_cut = not port.is_known_at(other, self.name)
            except FAULTS:
                return False
            self._settle(is_cut)
            if is_cut:
                return True
        if self.is_made_there() and not is_lost and not (is_known and self._ended):
            return False
        if is_lost and not self._is_rtgen:
            port.end_there(self.name, other)
        code = self._connect(port, other)
        # Both ends may have tried at once.
        if code is not RTC_OK and not port.has_link(self.name, other):
            raise PortTypeError(f"{self.there} refuses {self.here}: {code.name}")
        self._component = component
        if self._made:
            self._renewals += 1
            log.log(NOTE, "%s is connected again", self)
        self._made = time.monotonic()
        self._ended = self._in_doubt = False
        return True

    def _connect(self, port: PortService, other: Any) -> ReturnCode_t:
        """Connect the ports; one of the two processes does so, by request of the other, too.

        Tools cut a connection at its first port, which knows that it was cut on purpose.
        """
        is_made_there = self.is_made_there()
        ends = [other, port.reference] if is_made_there else [port.reference, other]
        asked = ConnectorProfile(self.name, self.name, ends, values(self.requested()))
        code, _ = (
            port.call_port(other, "connect", asked)
            if is_made_there
            else port.connect(asked)
        )
        return code

    def renew(self, directory: Directory) -> bool:
        """Re-establish the connection if it was lost, or ended by a component not of rtgen.

        A connection that was removed on purpose is not re-established. Returns False if the other
        component is missing. Raises as `attempt` does.
        """
        if not self.connected:
            return True
        port = self._objects.port(self.here)
        is_lost = port is not None and port.has_lost(self.name)
        if not is_lost and is_alive(self._component):
            is_due = self._ended and time.monotonic() >= self._due
            return not is_due or self.attempt(directory)
        return self.attempt(directory)

    @property
    def report(self) -> LinkReport | None:
        """The failures of the connection; None without."""
        port = self._objects.port(self.here)
        live = None if port is None else port.live(self.name)
        failed = live.failed if isinstance(live, SentConnector) else 0
        lost = self._failed + failed + self._not_received
        if not lost and not self._breaks:
            return None
        return LinkReport(
            *(str(self), self.there, lost, self._not_received),
            *(self._breaks, self._renewals, self._reason),
        )

    # Failures, see `Watcher`

    def on_refusal(self, reason: str) -> None:
        """Report the first sample that cannot be sent."""
        if not self._reason:
            log.warning("%s: a sample is not sent: %s", self, reason)
        self._reason = reason

    def on_loss(self, reason: str) -> None:
        """Report the loss; `renew` makes the connection again."""
        self._breaks += 1
        self._reason = reason
        log.warning(
            "%s is lost: %s; it is made again when %s answers",
            *(self, reason, self.there.instance),
        )

    def on_end(self) -> None:
        """Report the end, and make the connection again later, unless rtgen has ended it.

        That is on purpose if the other port does not have the connection any more. If it has, a
        request to end a former one was late.
        """
        if self._is_rtgen:
            self._ended = self._in_doubt = True
            self._due = 0.0
            return
        now = time.monotonic()
        if now - self._made > _MAX_DELAY:
            self._delay = _FIRST_DELAY
        self._due = now + self._delay
        self._delay = min(2 * self._delay, _MAX_DELAY)
        self._breaks += 1
        self._ended = True
        self._reason = f"by {self.there.instance}{self.cause_of_end()}"
        log.warning("%s was ended %s; it is made again", self, self._reason)

    def _settle(self, is_cut: bool) -> None:
        """Report an end by a component of rtgen."""
        self._in_doubt = False
        self._ended = not is_cut
        if is_cut:
            log.log(NOTE, "%s was cut in the other process", self)
        else:
            self._breaks += 1
            self._reason = "by a late request"
            log.warning("%s was ended %s; it is made again", self, self._reason)

    def cause_of_end(self) -> str:
        """Return why the other component may have ended the connection."""
        return ""

    def on_removal(self, connector: Connector | None) -> None:
        """Count the samples that were not taken."""
        if isinstance(connector, SentConnector):
            self._failed += connector.failed

    def _is_known(self, component: Any) -> bool:
        """Return whether a component is that of the last connection, not a restarted one."""
        return self._component is not None and self._component._is_equivalent(component)

    def _port_of(self, profile: Any) -> Any:
        """Return the port of a component. Raises PortTypeError."""
        wanted = known_name(self.there.port)
        names = []
        for port in profile.port_profiles:
            if texts(port.properties).get("port.port_type") != self.kind:
                continue
            name = known_name(port.name)
            names.append(name)
            if name in (wanted, f"{wanted}{self.suffix}"):
                self.check(port)
                return port.port_ref
        raise PortTypeError(
            f"{self.there} is not a {self.kind}; {self.there.instance} has: "
            f"{', '.join(names) or 'none'}"
        )

    def requested(self) -> dict[str, str]:
        """Return the properties of the connector."""
        return self.properties

    def is_made_there(self) -> bool:
        """Return whether the other component makes the connection itself."""
        return False

    def check(self, found: PortProfile) -> None:
        """Check the type of the other port. Raises PortTypeError."""


class PeerConnection(_Peer):
    """A connection of data ports."""

    here: InPort[Any] | OutPort[Any]

    suffix = "_out"

    def requested(self) -> dict[str, str]:
        """Return the properties with defaults and type."""
        descriptor: Any = self.here.type._descriptor_
        stated = DATA_DEFAULTS | {"dataport.data_type": descriptor.repository_id}
        return stated | self.properties

    def is_made_there(self) -> bool:
        """Return whether the process of the OutPort makes the connection, if that is rtgen's."""
        return not self._sends and self._is_rtgen

    def cause_of_end(self) -> str:
        """Return why; the sender ends a connection after a sample that it cannot send."""
        if not isinstance(self.here, InPort):
            return ""
        self._not_received += 1
        self.here.lost_when_cut += 1
        return (
            f", perhaps for a sample above its giopMaxMsgSize ({DEFAULT_LIMIT} octets unless "
            "corba.args of its rtc.conf has -ORBgiopMaxMsgSize)"
        )

    def check(self, found: PortProfile) -> None:
        """Compare the data types."""
        descriptor: Any = self.here.type._descriptor_
        type_ = texts(found.properties).get("dataport.data_type", "")
        if not is_same_type(type_, descriptor.repository_id):
            raise PortTypeError(
                f"{self.here} and {self.there} have different types: "
                f"{descriptor.repository_id} and {type_}"
            )


class ServicePeer(_Peer):
    """A connection between a service port here and a foreign one."""

    here: ServicePort
    suffix = "_service"

    def check(self, found: PortProfile) -> None:
        """Compare the types of interfaces: each must have a partner if strict, else one of them."""
        ways = (
            (PortInterfacePolarity.PROVIDED, self.here.consumers, "provider"),
            (PortInterfacePolarity.REQUIRED, self.here.providers, "consumer"),
        )
        partners = 0
        lonely: list[str] = []
        for polarity, ends, what in ways:
            offered = [i.type_name for i in found.interfaces if i.polarity == polarity]
            for end in ends:
                names = type_names(end)
                if any(
                    is_same_type(offer, name) for offer in offered for name in names
                ):
                    partners += 1
                else:
                    listed = ", ".join(offered) or "none"
                    lonely.append(f"{what} of {names[0]} for {end}; it has: {listed}")
        missing = [each for each in lonely if each.startswith("provider")]
        if missing and self.properties.get(STRICTNESS) == "strict":
            raise PortTypeError(f"{self.there} has no {missing[0]}")
        if not partners:
            raise PortTypeError(f"{self.there} has no {lonely[0]}")
