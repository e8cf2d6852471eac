"""Checks of a network: valid PDOs, unique COB-IDs, sufficient bandwidth."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.diagnostics import Diagnostic, Related
from rtgen.facts.canopen import EMERGENCY, SYNC
from rtgen.frontends.bus import rules
from rtgen.frontends.eds.findings import Findings
from rtgen.frontends.eds.pdos import PdoReader
from rtgen.frontends.eds.rules import pdos as pdo_rules
from rtgen.frontends.kit.located_toml import Toml
from rtgen.layouts.can_messages import identifier_of, messages
from rtgen.layouts.can_supervision import heartbeat_timeout
from rtgen.layouts.can_timing import load, response_times
from rtgen.model.can_bus import Bus, BusNode
from rtgen.model.canopen import Pdo, PdoDirection

_IMPOSSIBLE = {
    rule.code
    for rule in (
        pdo_rules.TOO_LONG,
        pdo_rules.NO_OBJECT,
        pdo_rules.NOT_MAPPABLE,
        pdo_rules.WRONG_WAY,
        pdo_rules.EMPTY_ENTRY,
        pdo_rules.BAD_GAP,
        pdo_rules.BAD_COB_ID,
    )
}


def check(bus: Bus, toml: Toml) -> Iterator[Diagnostic]:
    """Yield diagnostics for a bus whose file is well-formed."""
    for node in bus.nodes:
        yield from _mappings(node)
        yield from _like_its_kind(node)
        yield from _supervision(node)
        rates = node.device.info.bit_rates
        if rates and bus.bit_rate not in rates:
            message = f"{node.kind.path} does not name {bus.bit_rate} kbit/s"
            yield rules.NO_BIT_RATE.at(toml.span(("bus", "bit_rate")), message)
    yield from _cob_ids(bus)
    yield from _time(bus, toml)


def _mappings(node: BusNode) -> Iterator[Diagnostic]:
    device = node.device
    findings = Findings()
    unused = _unused(node)
    objects = [o for o in device.objects if o.index not in unused]
    PdoReader(objects, device.info, device.dummies, node.id, findings).read()
    for found in findings.diagnostics:
        if found.code in _IMPOSSIBLE:
            message = f"{node.name}: {found.message}"
            place = [] if found.span is None else [Related(found.span, found.code)]
            yield rules.BAD_MAPPING.at(node.span, message, related=place)


def _unused(node: BusNode) -> set[int]:
    """Return the indices of invalid PDOs that the bus file does not map.

    Problems with them are only warnings about the description.
    """
    written = {index for (index, _), _ in node.values}
    found: set[int] = set()
    for pdo in node.device.pdos:
        if not pdo.valid and pdo.mapping not in written:
            found |= {pdo.communication, pdo.mapping}
    return found


def _like_its_kind(node: BusNode) -> Iterator[Diagnostic]:
    kind = {(p.direction, p.number): p.entries for p in node.kind.device.pdos}
    for pdo in node.device.pdos:
        if pdo.entries != kind[pdo.direction, pdo.number]:
            yield rules.NOT_LIKE_KIND.at(
                node.span,
                f"{node.name}.{pdo.direction}{pdo.number} is mapped unlike that of "
                f"[device.{node.kind.name}]",
                related=[Related(node.kind.span, "the kind")],
                hint="give the node a kind of its own, with another name",
            )


def _supervision(node: BusNode) -> Iterator[Diagnostic]:
    if heartbeat_timeout(node):
        return
    numbers = (("1017", "its heartbeat"), ("100C", "node guarding"))
    hint = next(
        (
            f'`"{number}" = 100` in its `values` sets {what}, in ms'
            for number, what in numbers
            if (found := node.device.find(int(number, 16))) is not None
            and found.access.writable
        ),
        f"{node.kind.path} has neither 1017h nor 100Ch",
    )
    message = f"nobody notices when {node.name} fails: it has no heartbeat"
    yield rules.NO_SUPERVISION.at(node.span, message, hint=hint)


def _cob_ids(bus: Bus) -> Iterator[Diagnostic]:
    services = {SYNC: "SYNC"}
    services |= {
        EMERGENCY + node.id: f"the emergency messages of {node.name}"
        for node in bus.nodes
    }
    for node in bus.nodes:
        for pdo in node.device.pdos:
            service = services.get(identifier_of(pdo, node) or 0)
            if service is not None:
                message = (
                    f"{node.name}.{pdo.direction}{pdo.number} has the CAN identifier "
                    f"of {service}"
                )
                yield rules.SAME_COB_ID.at(node.span, message)
    sent: dict[int, tuple[BusNode, Pdo]] = {}
    for node in bus.nodes:
        for pdo in node.device.pdos:
            identifier = identifier_of(pdo, node)
            if identifier is None or pdo.direction is not PdoDirection.TPDO:
                continue
            other, known = sent.setdefault(identifier, (node, pdo))
            if known is not pdo:
                message = (
                    f"{node.name}.tpdo{pdo.number} has the CAN identifier of "
                    f"{other.name}.tpdo{known.number}, {identifier:X}h"
                )
                yield rules.SAME_COB_ID.at(
                    node.span, message, related=[Related(other.span, "the other node")]
                )
    linked = {(link.source, link.target) for link in bus.links}
    for node in bus.nodes:
        for pdo in node.device.pdos:
            identifier = identifier_of(pdo, node)
            if identifier not in sent or pdo.direction is not PdoDirection.RPDO:
                continue
            other, known = sent[identifier]
            if ((other.name, known.number), (node.name, pdo.number)) not in linked:
                message = (
                    f"{node.name}.rpdo{pdo.number} takes {other.name}.tpdo{known.number}, "
                    "and there is no [[link]] for it"
                )
                yield rules.SAME_COB_ID.at(node.span, message)


def _time(bus: Bus, toml: Toml) -> Iterator[Diagnostic]:
    sent = messages(bus)
    late = [t for t in response_times(sent, bus.bit_rate) if t.response is None]
    if late:
        share = load(sent, bus.bit_rate)
        message = (
            f"the messages take {share:.0%} of the bus; no bound for "
            f"{late[0].message.name} and {len(late) - 1} others"
        )
        yield rules.OVERLOAD.at(toml.span(("bus", "bit_rate")), message)
