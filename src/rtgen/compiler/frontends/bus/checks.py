"""Checks of a network: valid PDOs, unique COB-IDs, sufficient bandwidth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.frontends.bus import rules
from rtgen.compiler.frontends.eds.findings import Findings
from rtgen.compiler.frontends.eds.pdos import PdoReader, mapped_by
from rtgen.compiler.frontends.eds.rules import pdos as pdo_rules
from rtgen.compiler.frontends.kit.located_toml import Toml
from rtgen.compiler.layouts.can_messages import identifier_of, messages
from rtgen.compiler.layouts.can_services import (
    emergency_cob_id,
    produces_sync,
    waits_for_sync,
)
from rtgen.compiler.layouts.can_startup import obstacles
from rtgen.compiler.layouts.can_supervision import heartbeat_timeout
from rtgen.compiler.layouts.can_timing import load, response_times
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import Pdo, PdoDirection, resolved
from rtgen.facts.canopen import INVALID, can_id_of
from rtgen.facts.cob_ids import SDO_SERVERS
from rtgen.facts.write_order import CONSUMERS, MULTIPLEXED, consumed_node

_IMPOSSIBLE = {
    rule.code
    for rule in (
        pdo_rules.TOO_LONG,
        pdo_rules.NO_OBJECT,
        pdo_rules.NOT_MAPPABLE,
        pdo_rules.WRONG_WAY,
        pdo_rules.EMPTY_ENTRY,
        pdo_rules.BAD_GAP,
    )
}
_SHOWN_PDOS = 4
_DOUBTFUL = {rule.code for rule in (pdo_rules.OTHER_LENGTH, pdo_rules.GRANULARITY)}
"""A node may have mappings of parts of objects; most refuse them."""


def check(bus: Bus, toml: Toml) -> Iterator[Diagnostic]:
    """Yield diagnostics for a bus whose file is well-formed."""
    for node in bus.nodes:
        yield from _mappings(node)
        yield from _numbers_of_entries(node)
        yield from _like_its_kind(node)
        yield from _supervision(node)
        yield from _consumers(node)
        for variable, why in obstacles(node):
            place = f"{variable.index:04X}:{variable.subindex:X} {variable.name}"
            message = f"{node.name} may refuse the change of {place}: {why}"
            yield rules.REFUSED_CHANGE.at(node.span, message)
        rates = node.device.info.bit_rates
        if rates and bus.bit_rate not in rates:
            message = f"{node.kind.path} does not name {bus.bit_rate} kbit/s"
            yield rules.NO_BIT_RATE.at(toml.span(("bus", "bit_rate")), message)
        if node.lss and not node.device.info.lss:
            message = f"{node.kind.path} has no LSS_Supported=1"
            yield rules.NO_LSS.at(toml.span(("node", node.name, "lss")), message)
    yield from _without_sync(bus)
    yield from _cob_ids(bus)
    yield from _time(bus, toml)


def _mappings(node: BusNode) -> Iterator[Diagnostic]:
    """Yield the problems of mappings that are written, or of valid PDOs.

    A node takes what its own description maps; an empty entry only where that stands.
    """
    device = node.device
    written = {index for (index, _), _ in node.values}
    own = mapped_by(device)
    for is_written in (True, False):
        accepted = {e for e in own if not is_written or (e[1].index and e[1].bits)}
        others = {
            index
            for pdo in device.pdos
            if (pdo.mapping in written) != is_written or not (is_written or pdo.valid)
            for index in (pdo.communication, pdo.mapping)
        }
        objects = [o for o in device.objects if o.index not in others]
        findings = Findings()
        PdoReader(
            objects, device.info, device.dummies, node.id, findings, accepted
        ).read()
        for diagnostic in findings.diagnostics:
            yield from _problem(node, diagnostic)


def _problem(node: BusNode, diagnostic: Diagnostic) -> Iterator[Diagnostic]:
    if diagnostic.code in _IMPOSSIBLE:
        message = f"{node.name}: {diagnostic.message}"
        place = (
            []
            if diagnostic.span is None
            else [Related(diagnostic.span, diagnostic.code)]
        )
        yield rules.BAD_MAPPING.at(node.span, message, related=place)
    elif diagnostic.code in _DOUBTFUL:
        message = f"{node.name} may refuse a mapping: {diagnostic.message}"
        yield rules.REFUSED_CHANGE.at(node.span, message)


def _numbers_of_entries(node: BusNode) -> Iterator[Diagnostic]:
    """Yield the numbers of mapped objects in the bus file beyond the entries of the node."""
    written = dict(node.values)
    for pdo in node.device.pdos:
        used = written.get((pdo.mapping, 0))
        entries = sum(
            variable.index == pdo.mapping and variable.subindex > 0
            for variable in node.device.variables
        )
        if isinstance(used, int) and entries < used not in MULTIPLEXED:
            message = (
                f"{node.name}: {used} objects of {pdo.mapping:04X}h are mapped, "
                f"and it has {entries} entries"
            )
            yield rules.BAD_MAPPING.at(node.span, message)


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
            if (variable := node.device.find(int(number, 16))) is not None
            and variable.access.writable
        ),
        f"{node.kind.path} has neither 1017h nor 100Ch",
    )
    message = f"nobody notices when {node.name} fails: it has no heartbeat"
    yield rules.NO_SUPERVISION.at(node.span, message, hint=hint)


def _consumers(node: BusNode) -> Iterator[Diagnostic]:
    """Yield the entries of 1016h for the node of another one, which each node refuses."""
    seen: dict[int, int] = {}
    for variable in node.device.variables:
        value = resolved(variable.current, node.id)
        if variable.index != CONSUMERS or not variable.subindex:
            continue
        watched = consumed_node(value) if isinstance(value, int) else None
        if watched is None:
            continue
        other = seen.setdefault(watched, variable.subindex)
        if other != variable.subindex:
            message = (
                f"{node.name} consumes the heartbeat of node {watched} in "
                f"1016:{other:X} and 1016:{variable.subindex:X}"
            )
            yield rules.CONSUMED_TWICE.at(node.span, message)


def _without_sync(bus: Bus) -> Iterator[Diagnostic]:
    if bus.sync or any(map(produces_sync, bus.nodes)):
        return
    for node in bus.nodes:
        waiting = [
            f"{pdo.direction}{pdo.number}"
            for direction in PdoDirection
            for pdo in _waiting(node, direction)
        ]
        if waiting:
            more = ", ..." if len(waiting) > _SHOWN_PDOS else ""
            names = ", ".join(waiting[:_SHOWN_PDOS]) + more
            message = f"nobody sends SYNC, for which {node.name} waits: {names}"
            yield rules.NO_SYNC.at(node.span, message)


def _waiting(node: BusNode, direction: PdoDirection) -> Iterator[Pdo]:
    """Yield the PDOs of a direction that wait for SYNC.

    Those are that the bus file lets wait, or all: some of a device may have no use on a bus.
    """
    written = {number for number, _ in node.values}
    used = [
        pdo
        for pdo in node.device.pdos
        if pdo.direction is direction and pdo.valid and pdo.entries
    ]
    for pdo in used:
        is_chosen = (pdo.communication, 2) in written
        if waits_for_sync(pdo) and (is_chosen or all(map(waits_for_sync, used))):
            yield pdo


def _cob_ids(bus: Bus) -> Iterator[Diagnostic]:
    services = {can_id_of(bus.sync_cob_id): "SYNC"}
    for node in bus.nodes:
        for can_id, what in _own_services(node):
            mine = f"{what} of {node.name}"
            holder = services.setdefault(can_id, mine)
            if holder != mine:
                message = f"{mine} have the CAN identifier of {holder}, {can_id:X}h"
                yield rules.SAME_COB_ID.at(node.span, message)
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
            other, other_pdo = sent.setdefault(identifier, (node, pdo))
            if other_pdo is not pdo:
                message = (
                    f"{node.name}.tpdo{pdo.number} has the CAN identifier of "
                    f"{other.name}.tpdo{other_pdo.number}, {identifier:X}h"
                )
                yield rules.SAME_COB_ID.at(
                    node.span, message, related=[Related(other.span, "the other node")]
                )
    yield from _links(bus, sent)


def _own_services(node: BusNode) -> Iterator[tuple[int, str]]:
    """Yield the identifiers that only this node sends or serves, besides PDOs."""
    emergency = emergency_cob_id(node)
    if not emergency & INVALID:
        yield can_id_of(emergency), "the emergency messages"
    for index in SDO_SERVERS[1:]:
        variables = [node.device.find(index, sub) for sub in (1, 2)]
        cob_ids = [
            resolved(variable.in_force(node.id), node.id)
            for variable in variables
            if variable is not None
        ]
        for cob_id in cob_ids if len(cob_ids) == 2 else ():
            if isinstance(cob_id, int) and not cob_id & INVALID:
                yield can_id_of(cob_id), f"the messages of SDO server {index - 0x11FF}"


def _links(bus: Bus, sent: Mapping[int, tuple[BusNode, Pdo]]) -> Iterator[Diagnostic]:
    """Yield the RPDOs that receive a TPDO without a link."""
    linked = {(link.source, link.target) for link in bus.links}
    for node in bus.nodes:
        for pdo in node.device.pdos:
            identifier = identifier_of(pdo, node) or 0
            if identifier not in sent or pdo.direction is not PdoDirection.RPDO:
                continue
            other, tpdo = sent[identifier]
            if ((other.name, tpdo.number), (node.name, pdo.number)) not in linked:
                message = (
                    f"{node.name}.rpdo{pdo.number} takes {other.name}.tpdo{tpdo.number}, "
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
