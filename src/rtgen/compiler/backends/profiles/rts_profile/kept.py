"""Preserves content of a system's file that the model does not represent.

Preserved are elements, attributes and properties that rtgen does not interpret, and the file's
values of what rtgen only writes for the schema, such as `visible`. Dropped are references to
components that the system no longer has, and object references of connectors.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.compiler.model.profile_elements import RTS, RTS_EXT, Name, ProfileElement
from rtgen.facts.connector_properties import PROFILE_ATTRIBUTES
from rtgen.facts.openrtm_ports import known_name

_CONNECTORS = ("DataPortConnectors", "ServicePortConnectors")
_ORDER = (
    *("Components", "Groups", *_CONNECTORS),
    *("StartUp", "ShutDown", "Activation", "Deactivation", "Resetting"),
    *("Initializing", "Finalizing"),
    *("DataPorts", "ServicePorts", "ConfigurationSets", "ExecutionContexts"),
    *("Participants", "Location"),
    *("sourceDataPort", "targetDataPort", "sourceServicePort", "targetServicePort"),
    *("WaitTime", "Preceding", "TargetComponent", "VersionUpLogs", "Properties"),
)
"""The elements of a profile in the order of its schema."""
_DIRECTION: Name = (RTS_EXT, "direction")
_PLACES = {name: place for place, name in enumerate(_ORDER)}


def position(name: Name) -> int:
    """Return the position of an element among its siblings, by the order of the schema."""
    return _PLACES.get(name[1], len(_ORDER))


_OF_THE_MODEL = frozenset(
    {
        *("Components", *_CONNECTORS, "ConfigurationSets", "ConfigurationData"),
        *("targets", "WaitTime", "Preceding", "PrecedingComponents"),
    }
)
"""Elements that are only written if the model has them."""
_FOR_THE_SCHEMA: Mapping[str, frozenset[Name]] = {
    "Components": frozenset({(RTS, "compositeType"), (RTS_EXT, "visible")}),
    "DataPorts": frozenset({(RTS_EXT, "visible")}),
    "ServicePorts": frozenset({(RTS_EXT, "visible")}),
    "ExecutionContexts": frozenset({(RTS, "kind")}),
    "Location": frozenset({_DIRECTION}),
    "DataPortConnectors": frozenset({(RTS_EXT, "visible")}),
    "ServicePortConnectors": frozenset({(RTS_EXT, "visible")}),
    "Preceding": frozenset({(RTS, "timeout"), (RTS, "sendingTiming")}),
    "TargetComponent": frozenset({(RTS, "id")}),
    "PrecedingComponents": frozenset({(RTS, "id")}),
}
"""Attributes without a field of the model: the file's value is used, if there is one."""
EMPTY_WITHOUT = {
    "Groups": "Members",
    "Participants": "Participant",
    "Preceding": "PrecedingComponents",
    "targets": "TargetComponent",
    **dict.fromkeys(
        ("StartUp", "ShutDown", "Activation", "Deactivation", "Resetting"), "targets"
    ),
    **dict.fromkeys(("Initializing", "Finalizing"), "targets"),
}
"""Elements without meaning if they have no child of this name."""


def with_kept(
    element: ProfileElement, document: ProfileElement, *, all_ports: bool
) -> ProfileElement:
    """Return the root of a profile, completed by the content of the file's root.

    `all_ports`: the elements made have every port of the components, not only connected ones.
    """
    instances = frozenset(
        each.get(RTS, "instanceName") for each in element.all("Components")
    )
    merged = _Merge(instances, all_ports).element(element, document)
    activation = next(document.all("Activation"), None)
    if activation is None and _is_default(element):
        children = tuple(c for c in merged.children if c.name[1] != "Activation")
        merged = replace(merged, children=children)
    return merged


def _is_default(root: ProfileElement) -> bool:
    """Return whether the activation is the default: the required components first."""
    components = sorted(
        root.all("Components"), key=lambda c: c.get(RTS, "isRequired") != "true"
    )
    [activation, *_] = [*root.all("Activation"), None]
    if activation is None:
        return True
    steps = [*activation.all("targets")]
    conditions = [c for step in steps for c in step.children]
    return [_key(step) for step in steps] == [_key(c) for c in components] and all(
        c.name[1] != "Preceding" and c.get(RTS, "waitTime") in ("", "0")
        for c in conditions
    )


@dataclass(frozen=True, slots=True)
class _Merge:
    instances: frozenset[str]
    all_ports: bool

    def element(self, generated: ProfileElement, old: ProfileElement) -> ProfileElement:
        """Return an element of the model, completed by the content of the file's element."""
        first = _FOR_THE_SCHEMA.get(generated.name[1], frozenset())
        attributes = {
            name: (
                old.attributes.get(name, text)
                if name in first
                else _spelled(text, old.attributes.get(name))
            )
            for name, text in generated.attributes.items()
        }
        for name, text in old.attributes.items():
            attributes.setdefault(name, text)
        if _DIRECTION in attributes:
            # rtsprofile writes it in lower case, which violates the schema.
            attributes[_DIRECTION] = attributes[_DIRECTION].upper()
        return replace(
            generated,
            attributes=attributes,
            children=tuple(self._children(generated, old)),
            text=old.text if not generated.text else generated.text,
        )

    def _children(
        self, generated: ProfileElement, old: ProfileElement
    ) -> list[ProfileElement]:
        waiting = defaultdict(list)
        for child in generated.children:
            waiting[child.name, _key(child)].append(child)
        children = []
        for child in old.children:
            same = waiting[child.name, _key(child)]
            if same:
                children.append(self.element(same.pop(0), child))
            elif self._is_kept(child, generated):
                children += self._without_lost(child)
        children += [child for listed in waiting.values() for child in listed]
        return sorted(children, key=lambda child: position(child.name))

    def _is_kept(self, child: ProfileElement, parent: ProfileElement) -> bool:
        kind, inside = child.name[1], parent.name[1]
        if kind == "Properties" and inside in _CONNECTORS:
            # the value of an attribute, also written as a property
            attribute = PROFILE_ATTRIBUTES.get(child.get(RTS_EXT, "name"))
            value = child.get(RTS_EXT, "value")
            return attribute is not None and parent.get(RTS, attribute) == value
        if kind == "Properties":
            return inside != "RtsProfile"
        if kind in ("DataPorts", "ServicePorts"):
            return not self.all_ports
        return kind not in _OF_THE_MODEL

    def _without_lost(self, element: ProfileElement) -> list[ProfileElement]:
        """Return the element without references to other instances; none if nothing remains."""
        instance = element.get(RTS, "instanceName")
        if instance and instance not in self.instances:
            return []
        children = [p for child in element.children for p in self._without_lost(child)]
        needed = EMPTY_WITHOUT.get(element.name[1])
        lost = len(children) < len(element.children)
        if lost and needed and all(c.name[1] != needed for c in children):
            return []
        return [replace(element, children=tuple(children))]


def _key(element: ProfileElement) -> str:
    """Return the identity of an element among siblings of the same name."""
    match element.name[1]:
        case "Components" | "PrecedingComponents" | "TargetComponent":
            return element.get(RTS, "instanceName")
        case "DataPorts" | "ServicePorts":
            return known_name(element.get(RTS, "name"))
        case "DataPortConnectors" | "ServicePortConnectors":
            return _joined(element)
        case "ConfigurationSets" | "ExecutionContexts":
            return element.get(RTS, "id")
        case "ConfigurationData":
            return element.get(RTS, "name")
        case "Properties":
            return element.get(RTS_EXT, "name")
        case "targets":
            return next(map(_key, element.all("TargetComponent")), "")
    return ""


def _joined(connector: ProfileElement) -> str:
    """Return the two ends of a connector."""
    return " ".join(_ends(connector))


def _ends(connector: ProfileElement) -> Iterator[str]:
    for child in connector.children:
        if child.name[0] == RTS:
            port = known_name(child.get(RTS, "portName"))
            yield f"{child.get(RTS, 'instanceName')}.{port}"


def _spelled(text: str, old: str | None) -> str:
    """Return a number in the file's spelling, if its value is unchanged."""
    try:
        return old if old is not None and float(old) == float(text) else text
    except ValueError:
        return text
