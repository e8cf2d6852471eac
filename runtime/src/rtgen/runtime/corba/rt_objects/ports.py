"""Port services: profiles of ports, and connections by the chain of `notify_connect`."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace
from omniORB import CORBA

from rtgen.runtime.corba.iors import place
from rtgen.runtime.corba.rt_objects.data import DATA_DEFAULTS, Pulled, SentConnector
from rtgen.runtime.corba.rt_objects.objects import CallError
from rtgen.runtime.corba.rt_objects.port_ends import End, Link, Offer, Ports, Watcher
from rtgen.runtime.corba.rt_objects.wire import (
    PORT_SERVICE,
    ConnectorProfile,
    PortProfile,
    text_of,
    texts,
    values,
)
from rtgen.runtime.errors import RtcError
from rtgen.runtime.failures import log
from rtgen.runtime.return_codes import (
    BAD_PARAMETER,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    ReturnCode_t,
)
from rtgen.runtime.system.joining import Connector

if TYPE_CHECKING:
    from rtgen.runtime.system.system import System

_ENDS = 2


class _Losses:
    """What happens after a failure of a connection of a port."""

    def __init__(self, port: PortService, connector_id: str) -> None:
        self._port = port
        self._id = connector_id
        self.link: Link | None = None
        """The connection; None before it exists."""

    def refused(self, reason: str) -> None:
        """See `Losses`."""
        self._port.refuse(self._id, reason)

    def lost(self, reason: str, *, silent: bool) -> None:
        """See `Losses`; a process that does not answer loses all its connections."""
        if silent:
            self._port.give_up(self._id, reason)
        self._port.lose(self._id, reason, self.link)


class PortService:
    """`RTC::PortService` of a port; it includes the system's own connections."""

    def __init__(self, ports: Ports, instance: str, name: str, end: End) -> None:
        self.end = end
        self.instance = instance
        self.name = f"{instance}.{name}"
        self.owner: Any = None
        self._ports = ports
        self._links: dict[str, Link] = {}
        self._lost_ids: set[str] = set()
        """Connections that ended here because the other end did not respond."""
        self._cut_ids: set[str] = set()
        """Connections that this port is ending on request."""
        self._watchers: dict[str, Watcher] = {}
        self._changing = threading.Lock()
        """Held while a connection takes the place of one of the same id, or none does."""
        self.connecting = threading.Lock()
        """Held while a connection is made of which this port is the first."""
        self.reference: Any = ports.exported.serve(PORT_SERVICE, self)

    # Profiles

    def get_port_profile(self) -> PortProfile:
        """See `RTC::PortService`."""
        return PortProfile(
            self.name,
            self.end.interfaces,
            self.reference,
            self.get_connector_profiles(),
            self.owner,
            values(self.end.properties),
        )

    def get_connector_profiles(self) -> list[ConnectorProfile]:
        """See `RTC::PortService`."""
        links = [link.profile for link in tuple(self._links.values())]
        return links + [self._profile(connector) for connector in self._inner()]

    def get_connector_profile(self, connector_id: str) -> ConnectorProfile:
        """See `RTC::PortService`; an empty profile for an unknown id."""
        for profile in self.get_connector_profiles():
            if profile.connector_id == connector_id:
                return profile
        return ConnectorProfile("", "", [], [])

    def _inner(self) -> list[Connector]:
        """Return the system's connections that end here, except those to foreign ports."""
        system = self._ports.system
        if system is None:
            return []
        links = [link.connector for link in tuple(self._links.values())]
        return [
            connector
            for connector in system.connectors
            if self.end.has(connector) and connector not in links
        ]

    def _profile(self, connector: Connector) -> ConnectorProfile:
        ports = [each.reference for each in self._ports.at(connector)]
        stated = getattr(connector, "properties", {})
        properties = dict(self.end.properties) | dict(stated)
        for key in ("port.port_type", "dataport.dataflow_type"):
            properties.pop(key, None)
        if "dataport.interface_type" in properties:
            for key in ("dataport.subscription_type", "dataport.dataflow_type"):
                properties[key] = stated.get(key, DATA_DEFAULTS[key])
        name = connector.name
        identity = self._ports.ids.get(name, name)
        return ConnectorProfile(name, identity, ports, values(properties))

    # Connections

    def connect(self, profile: ConnectorProfile) -> tuple[ReturnCode_t, Any]:
        """See `RTC::PortService`. BAD_PARAMETER unless two ports fit, including this one."""
        if len(profile.ports) != _ENDS or None in profile.ports:
            log.warning("%s: a connection has two ports", self.name)
            return BAD_PARAMETER, profile
        if not profile.connector_id:
            profile = replace(profile, connector_id=str(uuid.uuid4()))
        ends = [self._ports.exported.local(each) for each in profile.ports]
        if all(isinstance(end, PortService) for end in ends):
            return self._join(profile, *ends), profile
        if ends[0] is not None:
            with ends[0].connecting:
                code, made = ends[0].notify_connect(profile)
        else:
            code, made = self.call_port(profile.ports[0], "notify_connect", profile)
        if code not in (RTC_OK, PRECONDITION_NOT_MET):
            self._notify_all(profile)
        return code, made

    def call_port(
        self, other: Any, operation: str, profile: ConnectorProfile
    ) -> tuple[ReturnCode_t, Any]:
        """Call another port with a profile; RTC_ERROR if it cannot be reached."""
        try:
            code, made = self._ports.exported.call(
                other, PORT_SERVICE, operation, profile
            )
        except (CORBA.SystemException, CallError) as error:
            log.warning("%s: the other port cannot be reached: %s", self.name, error)
            return RTC_ERROR, profile
        return code, made

    def _named(self, system: System, profile: ConnectorProfile) -> str:
        """Return the connection's name in the system, where names are unique."""
        name = profile.name or profile.connector_id
        if any(connector.name == name for connector in system.connectors):
            name = f"{name} ({profile.connector_id})"
        self._ports.ids[name] = profile.connector_id
        return name

    def _join(
        self, profile: ConnectorProfile, first: PortService, second: PortService
    ) -> ReturnCode_t:
        """Connect two ports of this process."""
        system = self._ports.system
        if system is None:
            return PRECONDITION_NOT_MET
        stated = texts(profile.properties)
        kept = {k: v for k, v in stated.items() if k != "dataport.data_type"}
        with self._refusing() as refused:
            system.connect(
                (first.instance, first.end.port),
                (second.instance, second.end.port),
                kept,
                self._named(system, profile),
            )
        return refused[0]

    def notify_connect(self, profile: ConnectorProfile) -> tuple[ReturnCode_t, Any]:
        """See `RTC::PortService`: offer interfaces, call the next port, then accept its offers."""
        system = self._ports.system
        identity = profile.connector_id
        if identity in self._links and not (
            self._is_same(identity, profile) and self._is_known_there(identity)
        ):
            # The other port was restarted, or has lost the connection: it is lost here, too.
            self._forget(identity)
            self._lost_ids.add(identity)
        if system is None or identity in self._links:
            return PRECONDITION_NOT_MET, profile
        name = self._named(system, profile)
        offer = Offer({})
        with self._refusing() as refused:
            offer = self.end.offer(name, texts(profile.properties))
        if refused[0] is not RTC_OK:
            return refused[0], profile
        added = [*profile.properties, *values(offer.properties)]
        code, profile = self._pass_on(replace(profile, properties=added))
        connector = offer.connector
        losses = _Losses(self, identity)
        if code is RTC_OK:
            with self._refusing() as refused:
                # Offers of this port itself are for the other end only.
                own = offer.properties.items()
                theirs = [
                    p
                    for p in profile.properties
                    if (p.name, text_of(p.value)) not in own
                ]
                connector = connector or self.end.accept(name, texts(theirs), losses)
                if connector is not None:
                    system.establish(connector)
            code = refused[0]
        if code is RTC_OK:
            losses.link = Link(profile, connector, offer.withdraw)
            with self._changing:
                self._links[identity] = losses.link
                self._lost_ids.discard(identity)
        else:
            offer.withdraw()
        return code, profile

    def _pass_on(self, profile: ConnectorProfile) -> tuple[ReturnCode_t, Any]:
        following = self._next(profile)
        if following is None:
            return RTC_OK, profile
        return self.call_port(following, "notify_connect", profile)

    def _next(self, profile: ConnectorProfile) -> Any:
        """Return the next port in a profile; None after the last."""
        mine = [port._is_equivalent(self.reference) for port in profile.ports]
        place = mine.index(True) if True in mine else len(mine)
        return next(iter(profile.ports[place + 1 :]), None)

    def disconnect(self, connector_id: str) -> ReturnCode_t:
        """See `RTC::PortService`. BAD_PARAMETER for an unknown id."""
        link = self._links.get(connector_id)
        if link is None:
            return self._cut(connector_id)
        self._cut_ids.add(connector_id)
        try:
            return self._notify_all(link.profile)
        finally:
            self._cut_ids.discard(connector_id)

    def has_link(self, connector_id: str, other: Any) -> bool:
        """Return whether there is a connection with this id to a port of another process.

        One with this id to another port, whose process has ended, is removed.
        """
        link = self._links.get(connector_id)
        if link is None:
            return False
        if any(port._is_equivalent(other) for port in link.profile.ports):
            return True
        self._forget(connector_id)
        return False

    def has_lost(self, connector_id: str) -> bool:
        """Return whether a connection has ended here because the other end did not respond."""
        return connector_id in self._lost_ids and connector_id not in self._links

    def end_there(self, connector_id: str, other: Any) -> None:
        """Make another port end a connection that it does not know to be lost."""
        self._notify(other, connector_id)

    def watch(self, connector_id: str, watcher: Watcher) -> None:
        """Tell a watcher of the failures of a connection, until `leave`."""
        self._watchers[connector_id] = watcher

    def is_linked(self, connector_id: str) -> bool:
        """Return whether there is a connection with this id to a port of another process."""
        return connector_id in self._links

    def live(self, connector_id: str) -> Connector | None:
        """Return a connection to a port of another process; None if there is none."""
        link = self._links.get(connector_id)
        return None if link is None else link.connector

    def leave(self, connector_id: str) -> None:
        """End a connection here, then at the other end, which may be gone."""
        self._lost_ids.discard(connector_id)
        link = self._forget(connector_id)
        self._watchers.pop(connector_id, None)
        for port in () if link is None else link.profile.ports:
            if self._ports.exported.local(port) is None:
                self._notify(port, connector_id)

    def _forget(self, connector_id: str) -> Link | None:
        """End a connection here only."""
        link = self._links.pop(connector_id, None)
        if link is not None:
            self._end(link)
        return link

    def _is_same(self, connector_id: str, profile: ConnectorProfile) -> bool:
        """Return whether a connection has the ports of a profile."""
        known = self._links[connector_id].profile.ports
        return len(known) == len(profile.ports) and all(
            one is not None and one._is_equivalent(other)
            for one, other in zip(known, profile.ports, strict=True)
        )

    def _is_known_there(self, connector_id: str) -> bool:
        """Return whether the other port of a connection responds, and has it, too."""
        for port in self._links[connector_id].profile.ports:
            if self._ports.exported.local(port) is None:
                try:
                    if not self.is_known_at(port, connector_id):
                        return False
                except (CORBA.SystemException, CallError):
                    return False
        return True

    def is_known_at(self, other: Any, connector_id: str) -> bool:
        """Return whether another port has a connection. Raises omniORB's exceptions, CallError."""
        found: ConnectorProfile = self._ports.exported.call(
            other, PORT_SERVICE, "get_connector_profile", connector_id
        )
        return found.connector_id == connector_id

    def disconnect_all(self) -> ReturnCode_t:
        """See `RTC::PortService`."""
        codes = [
            self.disconnect(profile.connector_id)
            for profile in self.get_connector_profiles()
        ]
        return next((code for code in codes if code is not RTC_OK), RTC_OK)

    def notify_disconnect(self, connector_id: str) -> ReturnCode_t:
        """See `RTC::PortService`: call the next port, then end the connection here."""
        link = self._links.pop(connector_id, None)
        if link is None:
            return self._cut(connector_id)
        following = self._next(link.profile)
        if following is not None:
            self._notify(following, connector_id)
        self._end(link)
        watcher = self._watchers.get(connector_id)
        if watcher is not None and not {connector_id} & (
            self._cut_ids | self._lost_ids
        ):
            watcher.on_end()
        return RTC_OK

    def _notify_all(self, profile: ConnectorProfile) -> ReturnCode_t:
        """Call the first port that responds to end the connection; the others follow it."""
        identity = profile.connector_id
        for port in profile.ports:
            if self._notify(port, identity):
                break
        if identity in self._links:
            self.notify_disconnect(identity)
        return RTC_OK

    def _notify(self, port: Any, connector_id: str) -> bool:
        local = self._ports.exported.local(port)
        if isinstance(local, PortService):
            return local.notify_disconnect(connector_id) is RTC_OK
        try:
            self._ports.exported.call(
                port, PORT_SERVICE, "notify_disconnect", connector_id
            )
        except (CORBA.SystemException, CallError) as error:
            log.info("%s: the other port is gone: %s", self.name, error)
            return False
        return True

    def _cut(self, connector_id: str) -> ReturnCode_t:
        """Remove a connection within the system."""
        system = self._ports.system
        for connector in self._inner():
            if self._profile(connector).connector_id == connector_id:
                assert system is not None  # it has the connection
                with self._refusing() as refused:
                    system.disconnect(connector)
                self._ports.ids.pop(connector.name, None)
                return refused[0]
        return BAD_PARAMETER

    def _end(self, link: Link) -> None:
        system = self._ports.system
        if system is not None and link.connector in system.connectors:
            assert link.connector is not None
            with self._refusing():
                system.disconnect(link.connector)
            self._ports.ids.pop(link.connector.name, None)
        link.withdraw()
        watcher = self._watchers.get(link.profile.connector_id)
        if watcher is not None:
            watcher.on_removal(link.connector)

    def refuse(self, connector_id: str, reason: str) -> None:
        """Report a sample that cannot be sent."""
        watcher = self._watchers.get(connector_id)
        if watcher is not None:
            watcher.on_refusal(reason)
        else:
            log.warning("%s, %s: %s", self.name, connector_id, reason)

    def lose(self, connector_id: str, reason: str, link: Link | None = None) -> None:
        """End a connection to a silent peer, in a new thread.

        The thread that detects it sends or publishes samples, and ending a connection waits for
        that. `link`: the connection, unless it is the one that has the id now; nothing is done if
        another one has taken its place.
        """
        with self._changing:
            present = self._links.get(connector_id)
            if connector_id in self._lost_ids or link not in (None, present):
                return
            self._lost_ids.add(connector_id)
        watcher = self._watchers.get(connector_id)
        if watcher is not None:
            watcher.on_loss(reason)
        else:
            log.warning("%s, %s is lost: %s", self.name, connector_id, reason)
        if present is not None:
            threading.Thread(
                target=self._end_lost, args=(connector_id, present), daemon=True
            ).start()

    def _end_lost(self, connector_id: str, link: Link) -> None:
        """End a lost connection, unless the other port has made it again meanwhile."""
        with self._changing:
            if self._links.get(connector_id) is not link:
                return
            del self._links[connector_id]
        following = self._next(link.profile)
        if following is not None:
            self._notify(following, connector_id)
        self._end(link)

    def give_up(self, connector_id: str, reason: str) -> None:
        """End the connections of the process to the silent one of a connection's other end."""
        link = self._links.get(connector_id)
        for port in () if link is None else link.profile.ports:
            if self._ports.exported.local(port) is None:
                found = place(self._ports.exported.text(port))
                self._ports.give_up(found, reason)

    def lose_all(self, silent: str, reason: str) -> None:
        """End the connections of this port to the process at a place."""
        exported = self._ports.exported
        for identity, link in [*self._links.items()]:
            ports = link.profile.ports
            others = [port for port in ports if exported.local(port) is None]
            if any(place(exported.text(port)) == silent for port in others):
                if isinstance(link.connector, SentConnector | Pulled):
                    link.connector.abandon()
                self.lose(identity, reason, link)

    @contextmanager
    def _refusing(self) -> Iterator[list[ReturnCode_t]]:
        """Yield a list for the return code of an exception in the block, which is logged."""
        code = [RTC_OK]
        try:
            yield code
        except RtcError as error:
            log.warning("%s: %s", self.name, error)
            code[0] = BAD_PARAMETER

    def close(self) -> None:
        """Close the connections to other processes, and deactivate the objects."""
        for link in list(self._links.values()):
            self._notify_all(link.profile)
        self._ports.exported.withdraw(self.reference)
