"""Base of ports: the profile, and connecting by passing a profile from port to port."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable
from typing import Any

import RTC
import RTC__POA
from omniORB import CORBA

from . import orb
from .NVUtil import list_of, properties_of
from .properties import Properties


class PortBase(RTC__POA.PortService):
    """Servant of a port; subclasses publish and subscribe the data of a connection."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._full_name = name
        self._instance = ""
        self._on_connected: Callable[[Any], None] | None = None
        self._owner: Any = None
        self._profile_properties = Properties()
        self._connections: dict[str, Any] = {}
        self._lock = threading.RLock()
        self._objref = self._this()

    def getName(self) -> str:
        return self._full_name

    def name(self) -> str:
        return self._name

    def getPortRef(self) -> Any:
        return self._objref

    def setOwner(self, owner: Any, instance: str) -> None:
        """Set the owner; only the part after the last dot of the port's name is kept."""
        self._owner = owner
        self._instance = instance
        self._full_name = f"{instance}.{self._name.rpartition('.')[2]}"

    def setOnConnected(self, on_connected: Callable[[Any], None]) -> None:
        """Set the function that is called with the profile of each new connection."""
        self._on_connected = on_connected

    def addProperty(self, key: str, value: str) -> None:
        self._profile_properties.setProperty(key, value)

    def getProfile(self) -> Any:
        return self.get_port_profile()

    def activateInterfaces(self) -> None:
        """Called when the component becomes active."""

    def deactivateInterfaces(self) -> None:
        """Called when the component becomes inactive."""

    def exit(self) -> None:
        """End all connections, then the port."""
        self.disconnect_all()
        poa = orb.poa()
        poa.deactivate_object(poa.servant_to_id(self))

    def publishInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        """Create this end of a connection, and add its address to `given`."""
        raise NotImplementedError

    def subscribeInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        """Read the address of the other end from `given`."""
        raise NotImplementedError

    def unsubscribeInterfaces(self, profile: Any) -> None:
        """End this end of a connection."""
        raise NotImplementedError

    def get_port_profile(self) -> Any:
        return RTC.PortProfile(
            self._full_name,
            self._interfaces(),
            self._objref,
            self.get_connector_profiles(),
            self._owner,
            list_of(self._profile_properties),
        )

    def _interfaces(self) -> list[Any]:
        return []

    def get_connector_profiles(self) -> list[Any]:
        with self._lock:
            return list(self._connections.values())

    def get_connector_profile(self, connector_id: str) -> Any:
        with self._lock:
            found = self._connections.get(connector_id)
        return found or RTC.ConnectorProfile("", "", [], [])

    def connect(self, profile: Any) -> tuple[Any, Any]:
        """Start with the first port of the profile; failures are undone."""
        if not profile.ports or any(CORBA.is_nil(port) for port in profile.ports):
            return RTC.BAD_PARAMETER, profile
        refused = self._refused(profile)
        if refused is not None:
            return refused, profile
        if not profile.connector_id:
            profile.connector_id = str(uuid.uuid4())
        elif profile.connector_id in self._connections:
            return RTC.PRECONDITION_NOT_MET, profile
        self._complete(profile)
        try:
            code, profile = profile.ports[0].notify_connect(profile)
        except CORBA.Exception:
            code = RTC.BAD_PARAMETER
        if code != RTC.RTC_OK:
            self.disconnect(profile.connector_id)
        return code, profile

    def _refused(self, profile: Any) -> Any:
        """Return a code that refuses the connection, or None."""
        return None

    def _complete(self, profile: Any) -> None:
        """Add the default properties of a connection."""

    def notify_connect(self, profile: Any) -> tuple[Any, Any]:
        """Publish, notify the next port, then subscribe."""
        given = dict(_texts(profile.properties))
        code = self.publishInterfaces(profile, given)
        if code == RTC.RTC_OK:
            profile.properties = _listed(given)
            with self._lock:
                self._connections[profile.connector_id] = profile
            following = self._next(profile)
            if following is not None:
                code, profile = following.notify_connect(profile)
        if code == RTC.RTC_OK:
            code = self.subscribeInterfaces(profile, dict(_texts(profile.properties)))
            with self._lock:
                self._connections[profile.connector_id] = profile
        if code == RTC.RTC_OK and self._on_connected is not None:
            self._on_connected(profile)
        return code, profile

    def disconnect(self, connector_id: str) -> Any:
        with self._lock:
            profile = self._connections.get(connector_id)
        if profile is None:
            return RTC.BAD_PARAMETER
        for port in profile.ports:
            try:
                return port.notify_disconnect(connector_id)
            except CORBA.Exception:
                continue
        return RTC.RTC_ERROR

    def notify_disconnect(self, connector_id: str) -> Any:
        with self._lock:
            profile = self._connections.pop(connector_id, None)
        if profile is None:
            return RTC.BAD_PARAMETER
        following = self._next(profile)
        code = RTC.RTC_OK
        if following is not None:
            try:
                code = following.notify_disconnect(connector_id)
            except CORBA.Exception:
                code = RTC.RTC_ERROR
        self.unsubscribeInterfaces(profile)
        return code

    def disconnect_all(self) -> Any:
        code = RTC.RTC_OK
        for profile in self.get_connector_profiles():
            if self.disconnect(profile.connector_id) != RTC.RTC_OK:
                code = RTC.RTC_ERROR
        return code

    def _next(self, profile: Any) -> Any:
        for place, port in enumerate(profile.ports):
            if port._is_equivalent(self._objref):
                rest = profile.ports[place + 1 :]
                return rest[0] if rest else None
        return None


def _texts(properties: list[Any]) -> list[tuple[str, str]]:
    tree = properties_of(properties)
    return [(key, tree.getProperty(key)) for key in tree.propertyNames()]


def _listed(given: dict[str, str]) -> list[Any]:
    tree = Properties()
    for key, value in given.items():
        tree.setProperty(key, value)
    return list_of(tree)
