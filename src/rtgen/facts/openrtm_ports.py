"""Names of components and ports on OpenRTM: one name space for all ports of a component.

OpenRTM only keeps the part of a name after its last dot (`PortBase.setOwner`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias

KIND: Final = "rtc"
"""The kind of the name of a component in a naming service: `Arm0.rtc`."""
RUNTIME: Final = "rtgen.runtime"
"""The property of components that tells those of rtgen, whose OutPorts make connections."""
FOREIGN: Final = "rtgen.foreign"
"""The property of a system that lists the instances that rtgen does not run."""

IN, OUT, SERVICE = "in", "out", "service"

Key: TypeAlias = tuple[str, str]
"""One of `IN`, `OUT`, `SERVICE`, and the name of a port in the definition."""

_SUFFIXES: Final = {IN: "", OUT: "_out", SERVICE: "_service"}


def foreign_instances(properties: Iterable[tuple[str, str]]) -> list[str]:
    """The instances that the properties of a system name as foreign, in their order."""
    stated = dict(properties).get(FOREIGN, "")
    return [name.strip() for name in stated.split(",") if name.strip()]


def known_name(name: str) -> str:
    """The name that OpenRTM uses for a port registered as `name`."""
    return name.rpartition(".")[2]


def registered_names(
    keys: Iterable[Key], chosen: Mapping[Key, str] | None = None
) -> dict[Key, str]:
    """Registration names for ports, unique in OpenRTM's name space."""
    listed = list(dict.fromkeys(keys))
    names: dict[Key, str] = {}
    for way, suffix in _SUFFIXES.items():
        taken = set(map(known_name, names.values()))
        for key in listed:
            if key[0] == way:
                clashes = known_name(key[1]) in taken
                names[key] = (chosen or {}).get(key) or key[1] + suffix * clashes
    return names
