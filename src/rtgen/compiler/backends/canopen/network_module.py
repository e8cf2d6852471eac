"""The module of a network: its nodes, their start-up, and their configured PDOs."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.component_module import Values
from rtgen.compiler.backends.canopen.literals import items
from rtgen.compiler.backends.canopen.objects_module import (
    identity_of,
    pdo_values,
    write_values,
)
from rtgen.compiler.backends.kit.python_module import PythonModule, python_module
from rtgen.compiler.backends.kit.quoting.python import Python
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.layouts.can_services import emergency_cob_id
from rtgen.compiler.layouts.can_startup import start_up
from rtgen.compiler.layouts.can_supervision import (
    guard_time,
    heartbeat,
    heartbeat_timeout,
)
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import resolved
from rtgen.facts.canopen import EMERGENCY, SYNC


def network_module(
    path: str, bus: Bus, origin: Sequence[str], options: Options
) -> PythonModule:
    """Return the module. Raises CanValueError for a value that cannot be written."""
    body = render(
        "canopen/network.py.j2",
        bus=bus,
        sync=round(bus.sync * 1_000_000),
        heartbeat=round(bus.heartbeat * 1000),
        nodes=[*map(_node, bus.nodes)],
        sync_cob_id=_number(bus.sync_cob_id, SYNC),
    )
    title = f"The network of `{bus.key}`."
    return python_module(path, options, origin, title, body=body)


def _node(node: BusNode) -> Values:
    numbers = ("None" if n is None else f"0x{n:X}" for n in identity(node))
    return {
        "of": node,
        "identity": items([*numbers]),
        "writes": [write_values(replace(w, relative=False)) for w in start_up(node)],
        "pdos": [pdo_values(pdo, node.device, node.id) for pdo in node.device.pdos],
        "heartbeat": heartbeat(node),
        "heartbeat_timeout": heartbeat_timeout(node),
        "boot_timeout": round(node.boot_timeout * 1000),
        "guard_time": guard_time(node),
        "emergency": _number(emergency_cob_id(node), EMERGENCY + node.id),
    }


def _number(cob_id: int, default: int) -> Python:
    return Python("" if cob_id == default else f"0x{cob_id:X}")


def identity(
    node: BusNode,
) -> tuple[int | None, int | None, int | None, int | None, int | None]:
    """Return the expected values of 1000h and 1018h:1 to 4; None, or 0 in the file, is not checked.

    Revision and serial number are those of one node: they are checked if the bus file or a DCF
    states them.
    """
    device = node.device
    commissioning = device.commissioning
    found = [
        identity_of(device, subindex) if device.find(0x1018, subindex) else None
        for subindex in range(1, 5)
    ]
    vendor, product, revision, serial = (number or None for number in found)
    if commissioning is None:
        revision = serial = None
    elif commissioning.serial_number:
        serial = commissioning.serial_number
    type_ = device.find(0x1000)
    number = None if type_ is None else resolved(type_.current, node.id)
    number = number if isinstance(number, int) and number else None
    return number, vendor, product, node.revision or revision, node.serial or serial
