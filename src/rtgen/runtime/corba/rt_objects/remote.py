"""A component of another process, rtgen's or OpenRTM's, through its CORBA objects."""

from __future__ import annotations

from typing import Any

from omniORB import any as anys

from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import (
    CONFIGURATION,
    EXECUTION_CONTEXT,
    PORT_SERVICE,
    RT_OBJECT,
    ConfigurationSet,
    Interface,
    NameValue,
    texts,
)
from rtgen.runtime.return_codes import LifeCycleState

_FOR_TOOLS = "__"
"""Prefix of the ids of sets that inform tools: `__widget__`, `__constraints__`."""


class NilError(Exception):
    """The component returned nil where a reference is required."""


class RemoteRtc:
    """A component to call. Methods raise omniORB's exceptions and NilError."""

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
