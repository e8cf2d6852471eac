"""Whether two ports can be connected, by what their profiles state: kinds, types, interfaces.

Names of types are those of RTC profiles: repository ids (`IDL:RTC/TimedLong:1.0`), scoped names, or
the last part alone, as in OpenRTM 1.
"""

from __future__ import annotations

from itertools import product
from typing import Final, NamedTuple

IN_PORT: Final = "DataInPort"
OUT_PORT: Final = "DataOutPort"
SERVICE_PORT: Final = "CorbaPort"
"""Values of `port.port_type`."""
_KINDS: Final = {
    IN_PORT: "an InPort",
    OUT_PORT: "an OutPort",
    SERVICE_PORT: "a service port",
}
_UNKNOWN: Final = ("", "any")
"""Data types that do not say which samples a port has."""


class StatedInterface(NamedTuple):
    """An interface of a service port: the name of its type, and whether it is provided."""

    type: str
    provided: bool


class StatedPort(NamedTuple):
    """A port: its kind, the name of its data type, or its interfaces."""

    kind: str
    type: str = ""
    interfaces: tuple[StatedInterface, ...] = ()


def scoped(name: str) -> str:
    """Return `RTC::TimedLong` for `IDL:RTC/TimedLong:1.0`; any other text unchanged."""
    if not name.startswith("IDL:"):
        return name
    return name.removeprefix("IDL:").rpartition(":")[0].replace("/", "::")


def is_same_type(one: str, other: str) -> bool:
    """Return whether two names are of one type, as far as they say; one may lack its scope."""
    ids = one.strip(), other.strip()
    first, second = map(scoped, ids)
    if first.lower() in _UNKNOWN or second.lower() in _UNKNOWN:
        return True
    complete = all(each.startswith("IDL:") for each in ids)
    if complete or ("::" in first and "::" in second):
        return first == second
    return first.rpartition("::")[2] == second.rpartition("::")[2]


def obstacle(one: StatedPort, other: StatedPort) -> str:
    """Return why two ports cannot be connected; empty if they can."""
    kinds = {one.kind, other.kind}
    if kinds == {SERVICE_PORT}:
        for a, b in product(one.interfaces, other.interfaces):
            if a.provided is not b.provided and is_same_type(a.type, b.type):
                return ""
        return "neither provides an interface that the other requires"
    if kinds != {IN_PORT, OUT_PORT}:
        return f"{_kind(one)} is not connected to {_kind(other)}"
    if not is_same_type(one.type, other.type):
        return f"they have different types: {scoped(one.type)} and {scoped(other.type)}"
    return ""


def _kind(port: StatedPort) -> str:
    return _KINDS.get(port.kind, "a service port")
