"""The module of a network: its nodes, how they are started, and what their PDOs are then."""

from __future__ import annotations

from rtgen.backends.canopen.literals import call, items, octets_literal
from rtgen.backends.canopen.objects_module import identity_of, pdo_text
from rtgen.backends.python_text import docstring, fit, string_literal
from rtgen.layouts.can_startup import start_up
from rtgen.model.can_bus import Bus, BusNode
from rtgen.model.canopen import resolved

_HEARTBEAT = 0x1017
_BOOT_TIMEOUT = 2000
_PERIODS = 3
"""A node is lost when so many of its heartbeats are missing."""


def network_text(bus: Bus, header: str) -> str:
    """The module. Raises CanValueError for a value that cannot be written."""
    nodes = [_node(node) for node in bus.nodes]
    used = ["Network", "NodeDescription"]
    used += ["PdoDescription"] * any(node.device.pdos for node in bus.nodes)
    used += ["Write"] * any(start_up(node) for node in bus.nodes)
    network = call(
        "Network",
        name=string_literal(bus.name),
        bit_rate=str(bus.bit_rate),
        manager=str(bus.manager),
        sync=str(round(bus.sync * 1_000_000)),
        heartbeat=str(round(bus.heartbeat * 1000)),
        nodes=items(nodes) if nodes else "()",
        sync_overflow=str(bus.sync_counter) if bus.sync_counter else "",
    )
    module = "rtgen.runtime.canopen.description"
    lines = [
        header + docstring(f"The network of `{bus.key}`.", 0).rstrip("\n"),
        "",
        "from __future__ import annotations",
        "",
        fit(f"from {module} import {', '.join(sorted(used))}"),
        "",
        fit(f"NETWORK = {network}"),
    ]
    return "\n".join(lines) + "\n"


def _node(node: BusNode) -> str:
    boot = round(node.boot_timeout * 1000)
    writes = [
        call(
            "Write",
            f"0x{w.variable.index:04X}",
            str(w.variable.subindex),
            octets_literal(w.value),
            verify="" if w.verify else "False",
        )
        for w in start_up(node)
    ]
    return call(
        "NodeDescription",
        name=string_literal(node.name),
        id=str(node.id),
        module=string_literal(node.kind.module),
        identity=items([_hex(told) for told in identity(node)]),
        configuration=items(writes),
        pdos=items([pdo_text(pdo, node.device, node.id) for pdo in node.device.pdos]),
        heartbeat=str(heartbeat(node)),
        heartbeat_timeout=str(heartbeat_timeout(node)),
        boot_timeout="" if boot == _BOOT_TIMEOUT else str(boot),
        restarts=str(node.restarts) if node.restarts else "",
        mandatory="" if node.mandatory else "False",
        start="" if node.start else "False",
        lss="True" if node.lss else "",
    )


def _hex(told: int | None) -> str:
    return "None" if told is None else f"0x{told:X}"


def heartbeat(node: BusNode) -> int:
    """The period of a node's heartbeat in ms, 0 for none."""
    variable = node.device.find(_HEARTBEAT)
    told = None if variable is None else variable.current
    return told if isinstance(told, int) else 0


def heartbeat_timeout(node: BusNode) -> int:
    """How long the manager waits for a heartbeat in ms, 0 if there is none."""
    if node.heartbeat_timeout is None:
        return _PERIODS * heartbeat(node)
    return round(node.heartbeat_timeout * 1000)


def identity(
    node: BusNode,
) -> tuple[int | None, int | None, int | None, int | None, int | None]:
    """What 1000h and 1018h:1 to 4 must hold; None, or 0 in the file, is not checked.

    Revision and serial number are those of one node: they are checked where the bus file or a DCF
    has them.
    """
    device = node.device
    told = device.commissioning
    found = [
        identity_of(device, subindex) if device.find(0x1018, subindex) else None
        for subindex in range(1, 5)
    ]
    vendor, product, revision, serial = (number or None for number in found)
    if told is None:
        revision = serial = None
    elif told.serial_number:
        serial = told.serial_number
    type_ = device.find(0x1000)
    number = None if type_ is None else resolved(type_.current, node.id)
    number = number if isinstance(number, int) and number else None
    return number, vendor, product, node.revision or revision, node.serial or serial
