"""Compares bus files: nodes, kinds of devices, PDO links and settings of the network."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import attrgetter

from rtgen.compiler.matching import matching
from rtgen.compiler.model.can_bus import Bus, BusNode, DeviceKind, PdoLink
from rtgen.tools.diff.changes import Change, change
from rtgen.tools.diff.devices import compare_device, shown
from rtgen.tools.diff.items import (
    Fact,
    Group,
    by_name,
    differing,
    fact_changes,
    item_changes,
    start_of,
)
from rtgen.tools.diff.kinds import devices as kinds
from rtgen.tools.diff.versions import Version

_NODES = Group("node", kinds.NODE_ADDED, kinds.NODE_REMOVED, kinds.NODE_RENAMED)
_BUSES = Group("bus", kinds.BUS_ADDED, kinds.BUS_REMOVED)
_FACTS = (
    Fact(kinds.BUS_BIT_RATE, "bit rate", lambda b: f"{b.bit_rate} kbit/s"),
    Fact(kinds.BUS_MANAGER, "manager", lambda b: b.manager),
    Fact(kinds.BUS_SYNC, "SYNC period", lambda b: f"{b.sync:g} s"),
    Fact(kinds.BUS_SYNC, "SYNC counter", lambda b: b.sync_counter),
    Fact(kinds.BUS_SYNC, "COB-ID of SYNC", lambda b: f"{b.sync_cob_id:X}h"),
    Fact(kinds.BUS_HEARTBEAT, "heartbeat", lambda b: f"{b.heartbeat:g} s"),
    Fact(kinds.BUS_SETTING, "time between events", lambda b: f"{b.event:g} s"),
    Fact(kinds.BUS_SETTING, "writing of DCF files", lambda b: b.dcf),
)
_KIND_FACTS = (
    Fact(
        kinds.KIND_PORTS,
        "{name} has other ports, parameters or operations",
        lambda k: (k.ports, {*k.parameters}, {*k.operations}),
    ),
    Fact(
        kinds.KIND_SCALE,
        "{name} has other factors or units",
        lambda k: (dict(k.factors), dict(k.units)),
    ),
)
_SUPERVISION = (
    *("heartbeat_timeout", "boot_timeout", "restarts", "mandatory", "start", "lss"),
    *("emergency_stop", "recoveries", "revision", "serial"),
)
_NODE_FACTS = (
    Fact(kinds.NODE_ID, "node-id", lambda n: n.id),
    *(
        Fact(
            kinds.NODE_SUPERVISION,
            f"{{name}} has {field} {{now}}, had {{was}}",
            attrgetter(field),
        )
        for field in _SUPERVISION
    ),
)


def compare_buses(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of buses."""
    found = matching(by_name(old.model.buses), by_name(new.model.buses))
    yield from item_changes(_BUSES, found, lambda b: b.name, place=start_of)
    for one, other in found.pairs:
        yield from _bus(one, other)


def _bus(old: Bus, new: Bus) -> Iterator[Change]:
    spans = (start_of(old), start_of(new))
    yield from fact_changes(_FACTS, old, new, new.name, spans, "bus")
    device_kinds = matching(by_name(old.kinds), by_name(new.kinds))
    for first, second in device_kinds.pairs:
        yield from _kind(first, second, f"{new.name}.{second.name}")
    nodes = matching(by_name(old.nodes), by_name(new.nodes), lambda n: n.id)
    names = {a.name: b.name for a, b in nodes.renamed}
    yield from item_changes(
        _NODES,
        nodes,
        lambda node: f"{new.name}.{node.name}",
        spans,
        label=lambda node: node.name,
    )
    for one, other in (*nodes.pairs, *nodes.renamed):
        yield from _node(one, other, f"{new.name}.{other.name}")
    before_links, after_links = {_renamed(each, names) for each in old.links}, set(
        new.links
    )
    for kind, links, verb in (
        (kinds.LINK_REMOVED, before_links - after_links, "removed"),
        (kinds.LINK_ADDED, after_links - before_links, "added"),
    ):
        for link in sorted(links, key=lambda each: (each.source, each.target)):
            (source, sent), (target, received) = link.source, link.target
            name = f"{new.name}.{source}.{sent}-{target}.{received}"
            text = f"link {name} is {verb}"
            yield change(kind, name, text, *spans)


def _renamed(link: PdoLink, names: Mapping[str, str]) -> PdoLink:
    """Return a link with the new names of its nodes."""
    ends = ((names.get(node, node), pdo) for node, pdo in (link.source, link.target))
    return PdoLink(*ends)


def _kind(old: DeviceKind, new: DeviceKind, name: str) -> Iterator[Change]:
    yield from fact_changes(
        _KIND_FACTS, old, new, name, (old.span, new.span), "device kind"
    )


def _node(old: BusNode, new: BusNode, name: str) -> Iterator[Change]:
    spans = (old.span, new.span)
    if old.kind.module != new.kind.module:
        text = f"node {name} is a {new.kind.module}, was a {old.kind.module}"
        other = any(each.wires for each in compare_device(old.device, new.device))
        wires = None if other else ()
        yield change(kinds.NODE_DEVICE, name, text, *spans, wires=wires)
    for key, first, second in sorted(differing(dict(old.values), dict(new.values))):
        item = f"{name}.{key[0]:04X}:{key[1]:02X}"
        text = f"{item} starts with {shown(second)}, did with {shown(first)}"
        yield change(kinds.NODE_VALUE, item, text, *spans)
    yield from fact_changes(_NODE_FACTS, old, new, name, spans, "node")
