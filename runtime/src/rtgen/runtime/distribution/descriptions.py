"""Descriptions of a process's instances for others: ports, types, interfaces, state; as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from rtgen.runtime.marshalling.comparison import definition
from rtgen.runtime.marshalling.descriptors import lineage
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext
from rtgen.runtime.rtc.profiles import ParameterProfile, PortProfile

MAX_OCTETS = 4 << 20
"""Maximum length of a description [octets]."""


class DataPort(msgspec.Struct, frozen=True):
    """A data port: the name of its type, and the definition as text."""

    type: str
    definition: str
    unit: str = ""
    doc: str = ""


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
    """The description of an instance; `rate` [Hz] and `kind` of its context, if known."""

    instance: str
    type: str
    in_ports: dict[str, DataPort]
    out_ports: dict[str, DataPort]
    providers: list[Interface]
    consumers: list[Interface]
    doc: str = ""
    rate: float | None = None
    kind: str = ""
    parameters: list[ParameterProfile] = []


def describe(
    component: Component, context: ExecutionContext | None = None
) -> Description:
    """Return the description of a component of this process, and of its own context."""
    profile = component.profile
    stated = {each.name: each for each in profile.ports if not each.port}

    def data_ports(ports: Mapping[str, Any]) -> dict[str, DataPort]:
        return {n: _data_port(port.type, stated.get(n)) for n, port in ports.items()}

    return Description(
        component.instance_name,
        profile.type_name,
        data_ports(component.in_ports),
        data_ports(component.out_ports),
        [
            _interface(*key, each.interface, each.exists)
            for key, each in component.providers.items()
        ],
        [_interface(*key, each.interface) for key, each in component.consumers.items()],
        profile.description,
        None if context is None else context.get_rate(),
        "" if context is None else context.get_kind().name,
        [*component.configuration_sets.parameters],
    )


def _data_port(type_: type, profile: PortProfile | None) -> DataPort:
    descriptor = type_._descriptor_  # type: ignore[attr-defined]
    texts = () if profile is None else (profile.unit, profile.description)
    return DataPort(descriptor.name, definition(descriptor), *texts)


def _interface(
    port: str, instance: str, class_: type, exists: bool = False
) -> Interface:
    descriptor = class_._descriptor_  # type: ignore[attr-defined]
    line = list(lineage(descriptor))
    operations = list(descriptor.operations)
    return Interface(port, instance, descriptor.name, line, operations, exists)
