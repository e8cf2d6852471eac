"""The changes that a user can make to an RtsProfile."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Final, TypeAlias

from rtgen.compiler.backends.profiles.rts_profile.elements import (
    ATTRIBUTE_DEFAULTS,
    InstancePorts,
    component_element,
    connector_element,
)
from rtgen.compiler.backends.profiles.rts_profile.kept import EMPTY_WITHOUT, position
from rtgen.compiler.model import Connection, SystemComponent
from rtgen.compiler.model.profile_elements import RTS, RTS_EXT
from rtgen.compiler.systems.conditions import (
    FINISHES,
    GOAL,
    PER_CYCLE,
    POSE,
    TOLERANCE,
    UNTIL,
)
from rtgen.facts.connector_properties import PROFILE_ATTRIBUTES
from rtgen.facts.openrtm_ports import FOREIGN
from rtgen.ui.documents.elements import Editable, editable

_CONNECTORS: Final = ("DataPortConnectors", "ServicePortConnectors")
_ENDS: Final = frozenset(
    f"{end}{kind}Port" for end in ("source", "target") for kind in ("Data", "Service")
)
_LISTS: Final = (
    FOREIGN,
    FINISHES,
    POSE,
    GOAL,
    PER_CYCLE,
)
"""Properties of a system that are lists of instances, or of names within instances."""
_JUDGED: Final = (POSE, GOAL)


class Profile:
    """An RtsProfile that changes; `root` is its root element."""

    def __init__(self, root: Editable) -> None:
        self.root = root

    # Components.

    def add(self, component: SystemComponent, ports: InstancePorts) -> None:
        """Add a component."""
        number = len([*self.root.all("Components")])
        element = editable(component_element(component, ports, number))
        self.root.insert(element, position)

    def add_foreign(self, component: SystemComponent, ports: InstancePorts) -> None:
        """Add a component of another process, unless there is one of its name."""
        if self._component(component.instance) is not None:
            return
        self.add(component, ports)
        names = _names(self._property(FOREIGN))
        _set_property(self.root, FOREIGN, ", ".join((*names, component.instance)))

    def remove(self, instance: str) -> None:
        """Remove a component with its connections, and all that refers to it."""
        self.root.children = [
            child
            for child in self.root.children
            if child.name[1] not in _CONNECTORS or instance not in _instances(child)
        ]
        _without(self.root, instance)
        lost = []
        for name in _LISTS:
            names = _names(self._property(name))
            remaining = [each for each in names if each.partition(".")[0] != instance]
            if remaining != names:
                _set_property(self.root, name, ", ".join(remaining))
                lost += [] if remaining else [name]
        if any(name in lost for name in _JUDGED):
            _set_property(self.root, TOLERANCE, "")
        until = _names(self._property(UNTIL))
        remaining = [
            each for each in until if each.partition("=")[0].strip() != instance
        ]
        if remaining != until:
            _set_property(self.root, UNTIL, ",".join(remaining))

    def move(self, instance: str, x: int, y: int) -> None:
        """Set the place of a component."""
        component = self._required(instance)
        place = component.first("Location")
        if place is None:
            rest = {"width": "-1", "height": "-1", "direction": "RIGHT"}
            attributes = {(RTS_EXT, name): text for name, text in rest.items()}
            place = Editable((RTS_EXT, "Location"), attributes)
            component.insert(place, position)
        place.attributes |= {(RTS_EXT, "x"): str(x), (RTS_EXT, "y"): str(y)}

    def configure(self, instance: str, set_id: str, parameter: str, text: str) -> None:
        """Set a parameter in a configuration set, which is added if there is none."""
        values = self._set(instance, set_id)
        for item in values.all("ConfigurationData"):
            if item.get("name") == parameter:
                item.attributes[RTS, "data"] = text
                return
        attributes = {(RTS, "name"): parameter, (RTS, "data"): text}
        values.insert(Editable((RTS, "ConfigurationData"), attributes), position)

    def activate_set(
        self, instance: str, set_id: str, values: Sequence[tuple[str, str]]
    ) -> None:
        """Make a configuration set the active one; `values` are those of one that is added."""
        component = self._required(instance)
        ids = [each.get("id") for each in component.all("ConfigurationSets")]
        if set_id not in ids:
            for parameter, text in values:
                self.configure(instance, set_id, parameter, text)
        component.attributes[RTS, "activeConfigurationSet"] = set_id

    def _set(self, instance: str, set_id: str) -> Editable:
        component = self._required(instance)
        for values in component.all("ConfigurationSets"):
            if values.get("id") == set_id:
                return values
        values = Editable((RTS, "ConfigurationSets"), {(RTS, "id"): set_id})
        component.insert(values, position)
        return values

    def _component(self, instance: str) -> Editable | None:
        components = self.root.all("Components")
        return next((c for c in components if c.get("instanceName") == instance), None)

    def _required(self, instance: str) -> Editable:
        component = self._component(instance)
        if component is None:
            raise LookupError(f"the file has no component {instance!r}")
        return component

    # Connections.

    def connect(self, connection: Connection) -> None:
        """Add a connection."""
        components = self.root.all("Components")
        ids = {each.get("instanceName"): each.get("id") for each in components}
        element = editable(connector_element(connection, ids))
        self.root.insert(element, position)

    def adjust(self, name: str, properties: Mapping[str, str]) -> None:
        """Set properties of a connection; an empty text: the default."""
        connector = next(
            child
            for child in self.root.children
            if child.name[1] in _CONNECTORS and connection_name(child) == name
        )
        for key, text in properties.items():
            if attribute := PROFILE_ATTRIBUTES.get(key):
                if text or connector.get(attribute):
                    value = text or ATTRIBUTE_DEFAULTS.get(key, "")
                    connector.attributes[RTS, attribute] = value
            else:
                _set_property(connector, key, text)

    def cut(self, name: str) -> None:
        """Remove a connection."""
        self.root.children = [
            child
            for child in self.root.children
            if child.name[1] not in _CONNECTORS or connection_name(child) != name
        ]

    # Properties of the system.

    def _property(self, name: str) -> str:
        for each in self.root.all("Properties"):
            if each.get("name", RTS_EXT) == name:
                return each.get("value", RTS_EXT)
        return ""


Change: TypeAlias = Callable[[Profile], None]
"""A change of a profile. Raises LookupError if the profile lacks what is changed."""


def _set_property(element: Editable, name: str, value: str) -> None:
    """Set a property of an element, or remove it if the value is empty."""
    properties = [
        each for each in element.all("Properties") if each.get("name", RTS_EXT) == name
    ]
    for each in properties:
        if value:
            each.attributes[RTS_EXT, "value"] = value
        else:
            element.children.remove(each)
    if value and not properties:
        attributes = {(RTS_EXT, "name"): name, (RTS_EXT, "value"): value}
        element.insert(Editable((RTS_EXT, "Properties"), attributes), position)


def connection_name(connector: Editable) -> str:
    """Return the name by which the reader of profiles knows a connection."""
    source, target = (f"{i}.{port}" for i, port in _ends(connector))
    stated = connector.get("name") or connector.get("connectorId")
    return stated or f"{source}_{target}"


def _ends(connector: Editable) -> Iterator[tuple[str, str]]:
    for child in connector.children:
        if child.name[1] in _ENDS:
            instance = child.get("instanceName")
            yield instance, child.get("portName").removeprefix(f"{instance}.")


def _instances(connector: Editable) -> Collection[str]:
    return {instance for instance, _ in _ends(connector)}


def _without(element: Editable, instance: str) -> None:
    """Remove all references to an instance, and what means nothing without them."""
    remaining = []
    for child in element.children:
        if child.get("instanceName") == instance:
            continue
        number = len(child.children)
        _without(child, instance)
        needed = EMPTY_WITHOUT.get(child.name[1])
        lost = len(child.children) < number
        if not (lost and needed and child.first(needed) is None):
            remaining.append(child)
    if element.name[1] == "targets" and len(remaining) < len(element.children):
        element.children = remaining
        if element.first("TargetComponent") and not element.first("WaitTime"):
            wait = Editable((RTS, "WaitTime"), {(RTS, "waitTime"): "0"})
            element.children.insert(0, wait)
        return
    element.children = remaining


def _names(text: str) -> list[str]:
    """Return the items of a comma-separated list."""
    return [name.strip() for name in text.split(",") if name.strip()]
