"""A component of another process, rtgen's or OpenRTM's, through its CORBA objects."""

from __future__ import annotations

import time
from typing import Any, Final

from omniORB import CORBA
from omniORB import any as anys

from rtgen.runtime.corba.faults import is_lost, is_timeout
from rtgen.runtime.corba.rt_objects.objects import CallError, Exported
from rtgen.runtime.corba.rt_objects.wire import (
    CONFIGURATION,
    EXECUTION_CONTEXT,
    PORT_SERVICE,
    RT_OBJECT,
    ComponentProfile,
    ConfigurationSet,
    Interface,
    NameValue,
    PortProfile,
    SdoError,
    texts,
)
from rtgen.runtime.errors import TransportError
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    LifeCycleState,
)

_FOR_TOOLS = "__"
"""Prefix of the ids of sets that inform tools."""
WIDGETS: Final = "__widget__"
CONSTRAINTS: Final = "__constraints__"
TYPES: Final = "__type__"
"""Ids of the sets in which OpenRTM's components describe their parameters."""
_POLL_INTERVAL = 0.01
_MAX_ENDED: Final = 8
"""Maximum number of ended processes to which one port is connected."""


class NilError(CallError):
    """The component returned nil where a reference is required."""


FAULTS: Final = (CORBA.SystemException, SdoError, CallError)
"""Exceptions of a call to a component."""


class RemoteRtc:
    """A component to call. Methods raise omniORB's exceptions and CallError."""

    def __init__(self, reference: Any, exported: Exported) -> None:
        self.reference = reference
        self.exported = exported

    # Calls

    def call(self, operation: str, *arguments: Any) -> Any:
        """Call the component."""
        return self._invoke(self.reference, RT_OBJECT, operation, *arguments)

    def ask(self, context: Any, operation: str, *arguments: Any) -> Any:
        """Call an execution context."""
        return self._invoke(context, EXECUTION_CONTEXT, operation, *arguments)

    def at_port(self, port: Any, operation: str, *arguments: Any) -> Any:
        """Call a port by its profile."""
        return self._invoke(port.port_ref, PORT_SERVICE, operation, *arguments)

    def _invoke(self, reference: Any, interface: Interface, *call: Any) -> Any:
        if reference is None:
            raise NilError(f"there is no object for {call[0]}: its reference is nil")
        return self.exported.call(reference, interface, *call)

    def configure(self, operation: str, *arguments: Any) -> Any:
        """Call the configuration."""
        found = self.call("get_configuration")
        return self._invoke(found, CONFIGURATION, operation, *arguments)

    @property
    def contexts(self) -> list[Any]:
        """The contexts that it owns."""
        found: list[Any] = self.call("get_owned_contexts")
        return found

    @property
    def context(self) -> Any:
        """The first context that it owns. Raises NilError."""
        for context in self.contexts:
            return context
        raise NilError("it owns no execution context")

    # Profiles

    def ports(self) -> list[PortProfile]:
        """Return the profiles of the ports, each from its port service."""
        return [self._port(port) for port in self.call("get_ports")]

    def _port(self, port: Any) -> PortProfile:
        """Return the profile of a port.

        OpenRTM-aist 2.1 (C++) removes connectors to ended processes meanwhile, and passes on the
        failure of its first call to each of them.
        """
        ended = 0
        while True:
            try:
                found: PortProfile = self._invoke(
                    port, PORT_SERVICE, "get_port_profile"
                )
            except CORBA.SystemException as error:
                ended += 1
                if not is_lost(error) or is_timeout(error) or ended > _MAX_ENDED:
                    raise
            else:
                return found

    def read_profile(self) -> ComponentProfile:
        """Return the profile of the component, after those of its ports.

        OpenRTM-aist 2.1 (C++) crashes in `get_component_profile` if a connector leads to a process
        that has ended since a port was read.
        """
        self.ports()
        found: ComponentProfile = self.call("get_component_profile")
        return found

    # Configuration

    def sets(self) -> dict[str, dict[str, str]]:
        """Return the values of the configuration sets, except those that inform tools."""
        found = self.all_sets()
        return {k: v for k, v in found.items() if not k.startswith(_FOR_TOOLS)}

    def all_sets(self) -> dict[str, dict[str, str]]:
        """Return the values of all sets, including those that inform tools."""
        found = self.configure("get_configuration_sets")
        return {each.id: texts(each.configuration_data) for each in found}

    def active_set(self) -> str:
        """Return the id of the active set."""
        found: str = self.configure("get_active_configuration_set").id
        return found

    def set_value(
        self, set_id: str, name: str, text: str, *, add: bool = False
    ) -> bool:
        """Set a parameter of a set, which is added if it is to be."""
        pair = NameValue(name, anys.to_any(text))
        given = ConfigurationSet(set_id, "", [pair])
        change = "add_configuration_set" if add else "set_configuration_set_values"
        return bool(self.configure(change, given))

    # States

    def state(self) -> LifeCycleState:
        """Return the state in its own context."""
        found: LifeCycleState = self.ask(
            self.context, "get_component_state", self.reference
        )
        return found

    def activate(self) -> None:
        """Request ACTIVE in its own context, after a reset if it is in ERROR.

        OpenRTM returns RTC_ERROR for a request that takes effect later. Raises TransportError if it
        refuses.
        """
        context = self.context
        state = self.state()
        if state is ERROR_STATE:
            self.ask(context, "reset_component", self.reference)
        if state is ACTIVE_STATE:
            return
        code = self.ask(context, "activate_component", self.reference)
        if code not in (RTC_OK, RTC_ERROR, PRECONDITION_NOT_MET):
            raise TransportError(f"it refuses to become active: {code.name}")

    def deactivate(self, seconds: float, *, pending: bool = False) -> LifeCycleState:
        """Request INACTIVE in its own context, and wait until it is no longer ACTIVE.

        `pending`: a request of ACTIVE may still wait for its execution. Returns the state, after at
        most `seconds` and the time-out of a call.
        """
        context = self.context
        deadline = time.monotonic() + seconds
        requested = False
        while True:
            state = self.state()
            if state is ACTIVE_STATE and not requested:
                code = self.ask(context, "deactivate_component", self.reference)
                requested = code is RTC_OK
                state = self.state()
            begins = pending and not requested and state is INACTIVE_STATE
            waits = state is ACTIVE_STATE or begins
            if not waits or time.monotonic() > deadline:
                return state
            time.sleep(_POLL_INTERVAL)
