"""Names of components and ports in OpenRTM: all ports of a component share one name space.

OpenRTM only keeps the part of a name after its last dot (`PortBase.setOwner`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias

KIND: Final = "rtc"
"""The kind in the name of a component in a naming service: `Arm0.rtc`."""
RUNTIME: Final = "rtgen.runtime"
"""Property of components that marks those of rtgen, whose OutPorts establish connections."""
FOREIGN: Final = "rtgen.foreign"
"""Property of a system with the instances that rtgen does not run."""

IN, OUT, SERVICE = "in", "out", "service"

Key: TypeAlias = tuple[str, str]
"""One of `IN`, `OUT`, `SERVICE`, and the name of a port in the definition."""

_SUFFIXES: Final = {IN: "", OUT: "_out", SERVICE: "_service"}


def foreign_instances(properties: Iterable[tuple[str, str]]) -> list[str]:
    """Return the instances listed as foreign in the properties of a system, in order."""
    stated = dict(properties).get(FOREIGN, "")
    return [name.strip() for name in stated.split(",") if name.strip()]


def known_name(name: str) -> str:
    """Return OpenRTM's name of a port registered as `name`."""
    return name.rpartition(".")[2]


def registered_names(
    keys: Iterable[Key], chosen: Mapping[Key, str] | None = None
) -> dict[Key, str]:
    """Return registration names of ports that are unique in OpenRTM's name space."""
    listed = list(dict.fromkeys(keys))
    names: dict[Key, str] = {}
    for way, suffix in _SUFFIXES.items():
        taken = set(map(known_name, names.values()))
        for key in listed:
            if key[0] == way:
                clashes = known_name(key[1]) in taken
                names[key] = (chosen or {}).get(key) or key[1] + suffix * clashes
    return names
