"""The module of a network: its nodes, their start-up, and their configured PDOs."""

from __future__ import annotations

from msgspec.structs import replace

from rtgen.backends.canopen.literals import call, items
from rtgen.backends.canopen.objects_module import identity_of, pdo_text, write_text
from rtgen.backends.kit.python_text import fit
from rtgen.backends.kit.quoting.python import docstring, string_literal
from rtgen.facts.canopen import EMERGENCY, SYNC
from rtgen.layouts.can_services import emergency_cob_id
from rtgen.layouts.can_startup import start_up
from rtgen.layouts.can_supervision import guard_time, heartbeat, heartbeat_timeout
from rtgen.model.can_bus import Bus, BusNode
from rtgen.model.canopen import resolved

_BOOT_TIMEOUT = 2000


def network_text(bus: Bus, header: str) -> str:
    """Return the module. Raises CanValueError for a value that cannot be written."""
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
        sync_cob_id="" if bus.sync_cob_id == SYNC else f"0x{bus.sync_cob_id:X}",
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
    emergency = emergency_cob_id(node)
    writes = [write_text(replace(w, relative=False)) for w in start_up(node)]
    return call(
        "NodeDescription",
        name=string_literal(node.name),
        id=str(node.id),
        module=string_literal(node.kind.module),
        identity=items([_hex(number) for number in identity(node)]),
        configuration=items(writes),
        pdos=items([pdo_text(pdo, node.device, node.id) for pdo in node.device.pdos]),
        heartbeat=str(heartbeat(node)),
        heartbeat_timeout=str(heartbeat_timeout(node)),
        boot_timeout="" if boot == _BOOT_TIMEOUT else str(boot),
        restarts=str(node.restarts) if node.restarts else "",
        mandatory="" if node.mandatory else "False",
        start="" if node.start else "False",
        lss="True" if node.lss else "",
        guard_time=str(guard_time(node)) if guard_time(node) else "",
        emergency_stop=string_literal(stops) if (stops := node.emergency_stop) else "",
        recoveries=str(node.recoveries) if node.recoveries else "",
        emergency="" if emergency == EMERGENCY + node.id else f"0x{emergency:X}",
    )


def _hex(number: int | None) -> str:
    return "None" if number is None else f"0x{number:X}"


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
