"""Lint checks of CANopen device descriptions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context
from rtgen.compiler.model.canopen import Device, Variable
from rtgen.compiler.typemap.canopen.names import identifier

_HEARTBEAT = 0x1017
_IDENTITY = 0x1018
_VENDOR = 1
_FIRST_OF_DEVICE = 0x2000
"""Objects below this index are the communication profile, which repeats names by design."""


def heartbeats(context: Context) -> Iterator[Diagnostic]:
    """Report devices without heartbeat, whose failure would not be noticed."""
    for device in context.model.devices:
        if device.find(_HEARTBEAT) is None:
            yield rules.NO_HEARTBEAT.at(
                device.span,
                f"{device.name} has no heartbeat (object 1017h)",
                hint="without it no manager and no proxy notices that a node is gone",
            )


def identities(context: Context) -> Iterator[Diagnostic]:
    """Report devices without an identity, which cannot be distinguished from others."""
    for device in context.model.devices:
        vendor = device.find(_IDENTITY, _VENDOR)
        vendor_id = device.vendor_id or (None if vendor is None else vendor.current)
        if not vendor_id:
            yield rules.NO_VENDOR.at(
                device.span if vendor is None else vendor.span,
                f"{device.name} has no vendor number (1018h sub-index 1)",
                hint="so a manager cannot know whether it is the right device",
            )


def unreachable(context: Context) -> Iterator[Diagnostic]:
    """Report application objects that SDO can only write, and no PDO maps."""
    for device in context.model.devices:
        mapped = {
            (entry.index, entry.subindex)
            for pdo in device.pdos
            for entry in (*pdo.entries, *pdo.default_entries)
        }
        for variable in device.variables:
            place = variable.number
            if (
                variable.index >= _FIRST_OF_DEVICE
                and not variable.access.readable
                and not variable.domain
                and place not in mapped
            ):
                yield rules.UNREACHABLE.at(
                    variable.span,
                    f"no SDO may read {variable.name} ({place[0]:04X}:{place[1]:X}),"
                    " and no PDO has it",
                    hint="with AccessType=rw a manager can check what it has written",
                )


def names(context: Context) -> Iterator[Diagnostic]:
    """Report application objects with equal names, whose fields are numbered."""
    for device in context.model.devices:
        for group in _with_equal_names(device):
            first, *others = group
            numbers = ", ".join(f"{v.index:04X}:{v.subindex:X}" for v in others)
            yield rules.SAME_NAME.at(
                first.span,
                f"{first.name} is also the name of {numbers}",
                related=[Related(others[0].span, "and here")],
                hint="the number of the object is appended to its fields and commands",
            )


def _with_equal_names(device: Device) -> list[list[Variable]]:
    variables: defaultdict[str, list[Variable]] = defaultdict(list)
    for variable in device.variables:
        if variable.index >= _FIRST_OF_DEVICE and not _is_count(device, variable):
            variables[identifier(variable.name).lower()].append(variable)
    return [group for group in variables.values() if len(group) > 1]


def _is_count(device: Device, variable: Variable) -> bool:
    """Return whether a variable is sub-index 0 of an object with other sub-indices."""
    return not variable.subindex and device.find(variable.index, 1) is not None
