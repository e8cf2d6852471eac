"""Data connections to components of other processes, rtgen's or OpenRTM's, found by their names."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from omniORB import CORBA

from rtgen.facts.openrtm_ports import KIND, RUNTIME, known_name
from rtgen.runtime.corba.naming import Naming, is_alive
from rtgen.runtime.corba.rt_objects.wire import (
    RT_OBJECT,
    ConnectorProfile,
    texts,
    values,
)
from rtgen.runtime.errors import PortTypeError, TransportError
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.return_codes import RTC_OK
from rtgen.runtime.services.transports import RemotePort

if TYPE_CHECKING:
    from rtgen.runtime.corba.rt_objects.publishing import RtObjects

_LOOK_AGAIN = 0.05
_DEFAULTS = {
    "dataport.interface_type": "corba_cdr",
    "dataport.dataflow_type": "push",
    "dataport.subscription_type": "flush",
}


class PeerConnection:
    """A connection of a data port of this process and one of another, made by `establish`."""

    def __init__(
        self,
        name: str,
        here: InPort[Any] | OutPort[Any],
        there: RemotePort,
        properties: Mapping[str, str],
        objects: RtObjects,
    ) -> None:
        sends = isinstance(here, OutPort)
        self.name = name
        self.source: Any = here if sends else there
        self.target: Any = there if sends else here
        self.properties = dict(properties)
        self.connected = False
        self.here = here
        self.there = there
        self._sends = sends
        self._objects = objects

    def attach(self) -> None:
        """Let `establish` make the connection."""
        self.connected = True

    def detach(self) -> None:
        """Remove the connection at both ends."""
        self.connected = False
        port = self._objects.port(self.here)
        if port is not None:
            port.leave(self.name)

    def establish(self, naming: Naming, deadline: float) -> None:
        """Make the connection, once there is the other component.

        Raises TransportError after an instant of `time.monotonic`, PortTypeError if the other
        port is missing, has another type, or refuses.
        """
        while not self._try(naming):
            if time.monotonic() > deadline:
                raise TransportError(
                    f"{self.here} waits for {self.there}; the naming service "
                    f"{naming.address} has no {self.there.instance}.{KIND} that answers"
                )
            time.sleep(_LOOK_AGAIN)

    def _try(self, naming: Naming) -> bool:
        component = naming.component(self.there.instance, KIND)
        port = self._objects.port(self.here)
        if port is None or not is_alive(component):
            return False
        try:
            profile, other = self._found(component)
        except CORBA.SystemException:
            return False
        if port.has_link(self.name):
            return True
        if not self._sends and RUNTIME in texts(profile.properties):
            return False
        ends = [port.reference, other] if self._sends else [other, port.reference]
        descriptor: Any = self.here.type._descriptor_
        stated = _DEFAULTS | {"dataport.data_type": descriptor.repository_id}
        asked = ConnectorProfile(
            self.name, self.name, ends, values(stated | self.properties)
        )
        code, _ = port.connect(asked)
        if code is not RTC_OK:
            raise PortTypeError(f"{self.there} refuses {self.here}: {code.name}")
        return True

    def _found(self, component: Any) -> tuple[Any, Any]:
        """The profile of the component, and its port. Raises PortTypeError."""
        call = self._objects.exported.call
        profile = call(component, RT_OBJECT, "get_component_profile")
        kind = "DataInPort" if self._sends else "DataOutPort"
        wanted = known_name(self.there.port)
        names = []
        for port in profile.port_profiles:
            properties = texts(port.properties)
            if properties.get("port.port_type") != kind:
                continue
            name = known_name(port.name)
            names.append(name)
            if name in (wanted, f"{wanted}_out"):
                self._check_type(properties.get("dataport.data_type", ""))
                return profile, port.port_ref
        raise PortTypeError(
            f"{self.there} is not a {kind}; {self.there.instance} has: "
            f"{', '.join(names) or 'none'}"
        )

    def _check_type(self, found: str) -> None:
        descriptor: Any = self.here.type._descriptor_
        short = descriptor.name.rpartition("::")[2]
        if found not in (descriptor.repository_id, short, ""):
            raise PortTypeError(
                f"{self.here} and {self.there} have different types: "
                f"{descriptor.repository_id} and {found}"
            )
