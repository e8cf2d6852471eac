"""The kinds of device in a project: those of its bus files, and one for each other file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.kit.words import words
from rtgen.compiler.lowering.canopen.rules import (
    BAD_PARAMETER,
    NO_DEFAULT,
    NO_PORT,
    SAME_MODULE,
    TAKEN_MODULE,
)
from rtgen.compiler.model import ScopedName
from rtgen.compiler.model.can_bus import Bus, DeviceKind, kind_of
from rtgen.compiler.model.canopen import Device
from rtgen.compiler.typemap.canopen.ports import DevicePorts, can_be_parameter
from rtgen.compiler.typemap.python.idl_names import package_path
from rtgen.compiler.typemap.python.names import module_name

_TAKEN = words("rtc canopen corba components adapters networks manager service _idl")


def kinds_of(
    devices: Sequence[Device], buses: Sequence[Bus]
) -> tuple[list[DeviceKind], list[Diagnostic]]:
    """A kind for each module, in the order of bus files, then files; and diagnostics."""
    kinds: dict[str, DeviceKind] = {}
    findings: list[Diagnostic] = []
    of_buses = [kind for bus in buses for kind in bus.kinds]
    files = {_file(kind.device) for kind in of_buses}
    beside = [kind_of(d) for d in devices if _file(d) not in files]
    for kind in (*of_buses, *beside):
        taken = _name_conflict(kind)
        if taken is not None:
            findings.append(taken)
            continue
        other = kinds.setdefault(kind.module.lower(), kind)
        if _settings(other) != _settings(kind):
            findings.append(
                SAME_MODULE.at(
                    kind.span,
                    f"{kind.module} is the name of two devices, or of one with two settings",
                    related=[Related(other.span, f"the other {other.module}")],
                    hint="give one of them another `name` in its bus file",
                )
            )
    return list(kinds.values()), findings


OBJECT_ACCESS = "ObjectAccess"
"""The interface with operations for single objects, in the module of a device."""
OBJECT_DICTIONARY: ScopedName = ("CANopen", "ObjectDictionary")
"""The interface of the SDO service."""


def service_of(kind: DeviceKind) -> ScopedName:
    """The interface of the SDO service of a kind's proxies."""
    return (kind.module, OBJECT_ACCESS) if kind.operations else OBJECT_DICTIONARY


def file_name(ports: DevicePorts) -> str:
    """The name of a device's IDL file in `#include`."""
    return f"{ports.kind.module}.idl"


def package_of(kind: DeviceKind) -> str:
    """Return the name of its Python package below the generated one: that of its IDL module."""
    [name] = package_path((kind.module,))
    return name


def check(ports: DevicePorts) -> Iterator[Diagnostic]:
    """Report what the components of a device cannot support."""
    for pdo, reason in ports.refused:
        name = f"{pdo.direction.upper()} {pdo.number}"
        yield NO_PORT.at(pdo.span, f"{name} of {ports.kind.module}: {reason}")
    for quantity in ports.parameters:
        variable = quantity.variable
        if not can_be_parameter(quantity):
            kind = "read-only" if not variable.access.writable else "of such a type"
            message = f"{quantity.name} cannot be a parameter: it is {kind}"
            yield BAD_PARAMETER.at(
                ports.kind.span, message, related=[Related(variable.span, "the object")]
            )
        elif variable.current is None:
            yield NO_DEFAULT.at(
                ports.kind.span,
                f"{quantity.name} has no default",
                related=[Related(variable.span, "the object")],
                hint="give it one under `values` of the kind",
            )


def _file(device: Device) -> tuple[str, str]:
    return device.key, device.sha256


def _settings(kind: DeviceKind) -> tuple[object, ...]:
    """The settings on which the generated code of a kind depends."""
    mapping = tuple((p.direction, p.number, p.entries) for p in kind.device.pdos)
    parameters = tuple(
        v.current if (v := kind.device.find(*number)) else None
        for number in kind.parameters
    )
    return (
        kind.module,
        _file(kind.device),
        kind.ports,
        kind.parameters,
        kind.operations,
        parameters,
        kind.factors,
        kind.units,
        mapping,
    )


def _name_conflict(kind: DeviceKind) -> Diagnostic | None:
    if _TAKEN.isdisjoint((kind.module.lower(), module_name(kind.module))):
        return None
    return TAKEN_MODULE.at(
        kind.span,
        f"a device cannot be called {kind.module}",
        hint="rename the file, or give it a `name` in the bus file",
    )
