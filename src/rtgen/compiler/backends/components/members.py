"""Python names of a component's ports and parameters."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from rtgen.compiler.model import Component, ConfigurationParameter, Port
from rtgen.compiler.typemap.components.names import (
    CANOPEN_NAMES,
    COMPONENT_NAMES,
    CONFIGURATION_NAMES,
)
from rtgen.compiler.typemap.python.idl_names import distinct


@dataclass(frozen=True, slots=True)
class Attributes:
    """Ports and parameters with their Python names."""

    ports: tuple[tuple[Port, str], ...]
    configuration: tuple[tuple[ConfigurationParameter, str], ...]


def attributes_of(component: Component, imported: Collection[str] = ()) -> Attributes:
    """Choose names: those of the definition, with `_` appended to those of Python or the runtime.

    `imported` are names in the types of the fields.
    """
    names = COMPONENT_NAMES
    if component.runtime_base:
        names |= CANOPEN_NAMES
    ports = distinct((p.identifier for p in component.ports), names)
    own = CONFIGURATION_NAMES.union(imported)
    fields = distinct((p.identifier for p in component.configuration), own)
    used: list[str] = []
    for port in component.ports:
        name = ports[port.identifier]
        while name in used:  # an InPort and an OutPort may have the same name
            name += "_"
        used.append(name)
    return Attributes(
        tuple(zip(component.ports, used, strict=True)),
        tuple((each, fields[each.identifier]) for each in component.configuration),
    )
