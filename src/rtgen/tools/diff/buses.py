"""Compares bus files: nodes, kinds of devices, PDO links and settings of the network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model.can_bus import Bus, BusNode, DeviceKind, PdoLink
from rtgen.tools.diff.changes import Change, change
from rtgen.tools.diff.devices import compare_device, shown
from rtgen.tools.diff.items import Fact, Group, fact_changes, item_changes
from rtgen.tools.diff.kinds import devices as kinds
from rtgen.tools.diff.matching import matching
from rtgen.tools.diff.versions import Version

_NODES = Group("node", kinds.NODE_ADDED, kinds.NODE_REMOVED, kinds.NODE_RENAMED)
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


def compare_buses(old: Version, new: Version) -> Iterator[Change]:
    """Yield the changes of buses."""
    found = matching(
        {b.name: b for b in old.model.buses},
        {b.name: b for b in new.model.buses},
        lambda _: None,
    )
    for bus in found.removed:
        text = f"bus {bus.name} is removed"
        yield change(kinds.BUS_REMOVED, bus.name, text, _place(bus), None)
    for bus in found.added:
        text = f"bus {bus.name} is added"
        yield change(kinds.BUS_ADDED, bus.name, text, None, _place(bus))
    for one, other in found.pairs:
        yield from _bus(one, other)


def _place(bus: Bus) -> Span:
    """Return the start of the bus file."""
    return Span(bus.file, 1, 1, 1, 2)


def _bus(old: Bus, new: Bus) -> Iterator[Change]:
    spans = (_place(old), _place(new))
    yield from fact_changes(_FACTS, old, new, new.name, spans, "bus")
    device_kinds = matching(
        {k.name: k for k in old.kinds}, {k.name: k for k in new.kinds}, lambda _: None
    )
    for first, second in device_kinds.pairs:
        yield from _kind(first, second, f"{new.name}.{second.name}")
    nodes = matching(
        {n.name: n for n in old.nodes}, {n.name: n for n in new.nodes}, lambda n: n.id
    )
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
    spans = (old.span, new.span)
    facts = [(k.ports, {*k.parameters}, {*k.operations}) for k in (old, new)]
    if facts[0] != facts[1]:
        text = f"device kind {name} has other ports, parameters or operations"
        yield change(kinds.KIND_PORTS, name, text, *spans)
    if (dict(old.factors), dict(old.units)) != (dict(new.factors), dict(new.units)):
        text = f"device kind {name} has other factors or units"
        yield change(kinds.KIND_SCALE, name, text, *spans)


def _node(old: BusNode, new: BusNode, name: str) -> Iterator[Change]:
    spans = (old.span, new.span)
    if old.id != new.id:
        text = f"node {name} has the node-id {new.id}, had {old.id}"
        yield change(kinds.NODE_ID, name, text, *spans)
    if old.kind.module != new.kind.module:
        text = f"node {name} is a {new.kind.module}, was a {old.kind.module}"
        other = any(each.wires for each in compare_device(old.device, new.device))
        wires = None if other else ()
        yield change(kinds.NODE_DEVICE, name, text, *spans, wires=wires)
    before, after = dict(old.values), dict(new.values)
    for key in sorted({*before, *after}):
        if before.get(key) != after.get(key):
            item = f"{name}.{key[0]:04X}:{key[1]:02X}"
            now, was = shown(after.get(key)), shown(before.get(key))
            text = f"{item} starts with {now}, did with {was}"
            yield change(kinds.NODE_VALUE, item, text, *spans)
    for word, value in _SUPERVISION:
        if value(old) != value(new):
            text = f"node {name} has {word} {value(new)}, had {value(old)}"
            yield change(kinds.NODE_SUPERVISION, name, text, *spans)


_SUPERVISION: tuple[tuple[str, Callable[[BusNode], object]], ...] = (
    ("heartbeat_timeout", lambda n: n.heartbeat_timeout),
    ("boot_timeout", lambda n: n.boot_timeout),
    ("restarts", lambda n: n.restarts),
    ("mandatory", lambda n: n.mandatory),
    ("start", lambda n: n.start),
    ("lss", lambda n: n.lss),
    ("emergency_stop", lambda n: n.emergency_stop),
    ("recoveries", lambda n: n.recoveries),
    ("revision", lambda n: n.revision),
    ("serial", lambda n: n.serial),
)
