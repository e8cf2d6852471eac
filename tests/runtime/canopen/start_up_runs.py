"""Runs of a network in simulated time: its manager, and nodes that enforce CiA 301."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from msgspec.structs import replace
from strict_node import OPERATIONAL, LiteralNode, StrictNode

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.canopen.network_module import network_module
from rtgen.compiler.backends.canopen.objects_module import objects_module
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends.bus import load
from rtgen.compiler.layouts.can_services import emergency_cob_id, uses_sync
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Network,
    NodeDescription,
)
from rtgen.runtime.canopen.master.managed_node import NodePhase
from rtgen.runtime.canopen.master.manager_station import ManagerStation
from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.wire.frames import CobId, Frame

SECOND = 1_000_000_000
TIME = 0.6
"""Seconds of a run, in addition to a heartbeat; SYNC comes each 0.02 s."""
_IDENTITY = ((0x1000, 0), (0x1018, 1), (0x1018, 2), (0x1018, 3), (0x1018, 4))


def read(file: Path) -> tuple[Bus | None, tuple[Diagnostic, ...]]:
    """Return a bus, None if its file has errors, and the findings."""
    result = load(file, root=file.parent)
    return (None if has_errors(result.diagnostics) else result.bus), result.diagnostics


def network_of(bus: Bus) -> Network:
    """Return the generated network."""
    made: dict[str, Any] = {"__name__": "network"}
    exec(network_module("network.py", bus, (), Options("p", "", "1")).text, made)
    network = made["NETWORK"]
    assert isinstance(network, Network)
    return network


def device_of(node: BusNode) -> DeviceDescription:
    """Return the description of a node's device as generated."""
    made: dict[str, Any] = {"__name__": "device"}
    ports = DevicePorts(node.kind.device, node.kind)
    exec(objects_module("d.py", ports, Options("devices", "", "0")).text, made)
    found = made["DESCRIPTION"]
    assert isinstance(found, DeviceDescription)
    return found


def problems_of_devices(bus: Bus, findings: tuple[Diagnostic, ...]) -> Iterator[str]:
    """Run the start-up of a network with generated devices; yield what is wrong."""
    warned = _warned(bus, findings)
    system = System()
    assert system.clock.network is not None
    link = simulated_bus(system.clock.network, "can0", 1_000_000)
    network = network_of(bus)
    sent: dict[int, list[Frame]] = {}
    devices = {}
    for node in bus.nodes:
        placed = network.node(node.id)
        assert placed is not None
        described = _identified(device_of(node), placed)
        device = devices[node.id] = DeviceNode(described, node.id)
        own = sent[node.id] = []
        for name in ("receive", "poll"):
            setattr(device, name, _recorded(getattr(device, name), own))
        link.attach(device)
        link.send(device.boot(0), device)
        link.refresh(device)
    manager = ManagerStation(link, network)
    manager.start()
    system.run(_end(network))
    for node in bus.nodes:
        device, managed = devices[node.id], manager.nodes[node.id]
        if node.name in warned:
            continue
        if managed.phase is not NodePhase.RUNNING:
            yield f"the device of {node.name} is {managed.phase.name}: {managed.reason}"
            continue
        device.add_error(0x1001)
        now = link.now()
        emergencies = [f for f in device.flush(now) if f.data[:2] == b"\1\x10"]
        cob_id = CobId(emergency_cob_id(node))
        has = cob_id.valid and node.device.find(0x1014) is not None
        wanted = [cob_id.can_id] if has and not _inhibited(node) else []
        if not _inhibited(node) and [f.can_id for f in emergencies] != wanted:
            yield f"the device of {node.name} sends {emergencies}, not on {wanted}"
        if any(f.can_id < 0x80 and not f.extended for f in sent[node.id]):
            yield f"the device of {node.name} sends on a restricted identifier"
    system.close()


def _identifier(cob_id: int) -> tuple[int, bool] | None:
    """Return the identifier of a service, None if it is off."""
    found = CobId(cob_id)
    return (found.can_id, found.extended) if found.valid else None


def _end(network: Network) -> int:
    """Return the time at which each node has sent a heartbeat."""
    longest = max((node.heartbeat for node in network.nodes), default=0)
    return round(TIME * SECOND) + 2 * longest * 1_000_000


def _identified(
    device: DeviceDescription, placed: NodeDescription
) -> DeviceDescription:
    """Return a device with the identity that the network expects."""
    wanted = dict(zip(_IDENTITY, placed.identity, strict=True))
    objects = tuple(
        (
            thing
            if wanted.get((thing.index, thing.subindex)) is None
            else replace(thing, default=wanted[thing.index, thing.subindex])
        )
        for thing in device.objects
    )
    return replace(device, objects=objects)


def _warned(bus: Bus, findings: tuple[Diagnostic, ...]) -> set[str]:
    """Return the nodes of which a finding says that they may refuse a value."""
    return {
        node.name
        for node in bus.nodes
        for d in findings
        if d.code == "EDS0715" and d.message.startswith(f"{node.name} ")
    }


def _inhibited(node: BusNode) -> bool:
    inhibit = node.device.find(0x1015)
    return inhibit is not None and bool(inhibit.current)


def _recorded(
    call: Callable[..., Iterable[Frame]], sent: list[Frame]
) -> Callable[..., Iterable[Frame]]:
    def recorded(*arguments: Any) -> Iterable[Frame]:
        frames = list(call(*arguments))
        sent.extend(frames)
        return frames

    return recorded


def refusals(bus: Bus, findings: tuple[Diagnostic, ...]) -> Iterator[str]:
    """Run the start-up with nodes that take COB-IDs literally; yield the writes they refuse."""
    system = System()
    assert system.clock.network is not None
    link = simulated_bus(system.clock.network, "can0", 1_000_000)
    network = network_of(bus)
    nodes = {}
    for node in bus.nodes:
        literal = LiteralNode(node.kind.described or node.device, node.id)
        placed = network.node(node.id)
        assert placed is not None
        literal.identity = dict(zip(_IDENTITY, placed.identity, strict=True))
        nodes[node.name] = literal
        link.attach(literal)
        literal.power_on(0)
        link.refresh(literal)
    ManagerStation(link, network).start()
    system.run(_end(network))
    for name in nodes.keys() - _warned(bus, findings):
        for (index, sub), value, code in nodes[name].refused[:1]:
            yield f"{name} refuses {index:04X}:{sub:X} {value.hex()}: {code:08X}h"
    system.close()


def problems(bus: Bus, findings: tuple[Diagnostic, ...]) -> Iterator[str]:
    """Run the start-up of a network with nodes that enforce CiA 301; yield what is wrong."""
    system = System()
    assert system.clock.network is not None
    link = simulated_bus(system.clock.network, "can0", 1_000_000)
    network = network_of(bus)
    nodes = {
        node.id: StrictNode(node.kind.described or node.device, node.id)
        for node in bus.nodes
    }
    for node in bus.nodes:
        # The node is as its file describes it, without the values of the bus file.
        placed = network.node(node.id)
        assert placed is not None
        nodes[node.id].identity = dict(zip(_IDENTITY, placed.identity, strict=True))
        link.attach(nodes[node.id])
        nodes[node.id].power_on(0)
        link.refresh(nodes[node.id])
    manager = ManagerStation(link, network)
    manager.start()
    system.run(_end(network))
    warned = _warned(bus, findings)
    for node in bus.nodes:
        strict, managed = nodes[node.id], manager.nodes[node.id]
        placed = network.node(node.id)
        assert placed is not None
        if any(f.can_id < 0x80 and not f.extended for f in strict.sent):
            yield f"{node.name} sends on a restricted identifier"
        if strict.refused and node.name not in warned:
            (index, sub), value, code = strict.refused[0]
            yield f"{node.name} refuses {index:04X}:{sub:X} {value.hex()}: {code:08X}h"
        if strict.refused:
            continue
        if managed.phase is not NodePhase.RUNNING or managed.reason:
            yield f"{node.name} is {managed.phase.name}: {managed.reason}"
            continue
        if strict.state != OPERATIONAL or strict.resets != 1:
            yield f"{node.name}: state {strict.state}, {strict.resets} resets"
        if bus.sync and strict.odd_syncs:
            yield f"{node.name} hears SYNC of another length"
        if bus.sync and uses_sync(node) and strict.syncs < 5:
            yield f"{node.name} does not hear SYNC: {strict.syncs}"
        emergencies = strict.number((0x1014, 0), placed.emergency_cob_id)
        if _identifier(emergencies) != _identifier(placed.emergency_cob_id):
            yield f"{node.name}: emergencies on {emergencies:X}h, not {placed.emergency}"
        known = {
            p.cob_id_of(node.id)
            for p in placed.pdos
            if p.direction == "tpdo" and any(index for index, _, _ in p.mapping)
        }
        valid = {cob_id for cob_id in known if CobId(cob_id).valid}
        if set(strict.tpdos()) != valid:
            yield f"{node.name}: TPDOs {strict.tpdos()}, the network has {sorted(valid)}"
    system.close()
