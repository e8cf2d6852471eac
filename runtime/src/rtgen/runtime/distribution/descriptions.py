"""Descriptions of a process's instances for others: ports, types, interfaces, state; as JSON."""

from __future__ import annotations

import msgspec

from rtgen.runtime.marshalling.comparison import definition
from rtgen.runtime.marshalling.descriptors import lineage
from rtgen.runtime.rtc.component import Component

MAX_OCTETS = 4 << 20
"""Maximum length of a description [octets]."""


class DataPort(msgspec.Struct, frozen=True):
    """A data port: the name of its type, and the definition as text."""

    type: str
    definition: str


class Interface(msgspec.Struct, frozen=True):
    """A provided or required interface, with the ids of all its bases.

    `exists`: whether calls are served now.
    """

    port: str
    instance: str
    name: str
    lineage: list[str]
    operations: list[str]
    exists: bool = False


class Description(msgspec.Struct, frozen=True):
    """The description of an instance."""

    instance: str
    type: str
    in_ports: dict[str, DataPort]
    out_ports: dict[str, DataPort]
    providers: list[Interface]
    consumers: list[Interface]


def describe(component: Component) -> Description:
    """Return the description of a component of this process."""
    return Description(
        component.instance_name,
        component.profile.type_name,
        {name: _data_port(port.type) for name, port in component.in_ports.items()},
        {name: _data_port(port.type) for name, port in component.out_ports.items()},
        [
            _interface(*key, each.interface, each.exists)
            for key, each in component.providers.items()
        ],
        [_interface(*key, each.interface) for key, each in component.consumers.items()],
    )


def _data_port(type_: type) -> DataPort:
    descriptor = type_._descriptor_  # type: ignore[attr-defined]
    return DataPort(descriptor.name, definition(descriptor))


def _interface(
    port: str, instance: str, class_: type, exists: bool = False
) -> Interface:
    descriptor = class_._descriptor_  # type: ignore[attr-defined]
    line = list(lineage(descriptor))
    operations = list(descriptor.operations)
    return Interface(port, instance, descriptor.name, line, operations, exists)
