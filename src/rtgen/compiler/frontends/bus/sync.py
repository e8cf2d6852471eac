"""SYNC of a network: its identifier, and the values with which each node hears it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.bus import rules
from rtgen.compiler.frontends.bus.values import BadValueError, configured
from rtgen.compiler.layouts.can_services import produces_sync, sync_cob_id, uses_sync
from rtgen.compiler.model.can_bus import BusNode
from rtgen.facts.canopen import SYNC
from rtgen.facts.cob_ids import COB_ID_SYNC, configurable
from rtgen.facts.write_order import OVERFLOW

_IDENTIFIER = 0x3FFFFFFF
"""Bits of a COB-ID that a frame must have: its identifier, and whether it has 29 bits."""


def sync_of(nodes: Sequence[BusNode]) -> int:
    """Return the COB-ID of SYNC: the one that the nodes are given in common, or 80h."""
    identifiers = {
        sync_cob_id(node) & _IDENTIFIER
        for node in nodes
        if uses_sync(node) and _is_chosen(node, COB_ID_SYNC)
    }
    [cob_id] = identifiers if len(identifiers) == 1 else {SYNC}
    return cob_id if configurable(cob_id) else SYNC


def synchronised(
    node: BusNode, cob_id: int, counter: int, report: Callable[[Diagnostic], None]
) -> BusNode:
    """Return a node with the values with which it hears the manager's SYNC.

    `counter` is the highest SYNC counter, 0 for none. Reports what cannot be written.
    """
    produces = produces_sync(node)
    deaf = uses_sync(node) and sync_cob_id(node) & _IDENTIFIER != cob_id
    if deaf or produces:
        what = f"hears SYNC on {sync_cob_id(node) & _IDENTIFIER:X}h"
        if produces:
            what = "sends SYNC, too"
        node = _with(node, COB_ID_SYNC, cob_id, what, f"{cob_id:X}h", report)
    overflow = node.device.number(*OVERFLOW) or 0
    if node.device.find(*OVERFLOW) is not None and overflow != counter:
        what = f"expects the SYNC counter {overflow}"
        node = _with(node, OVERFLOW, counter, what, str(counter), report)
    return node


def _with(
    node: BusNode,
    number: tuple[int, int],
    value: int,
    what: str,
    reason: str,
    report: Callable[[Diagnostic], None],
) -> BusNode:
    """Return the node with a value that nobody has chosen; else report what is wrong."""
    if not _is_chosen(node, number):
        try:
            device, written = configured(node.device, number, value, node.span)
        except BadValueError as error:
            what = f"{what}, and {error}"
        else:
            values = dict(node.values) | {number: written}
            return replace(node, device=device, values=tuple(sorted(values.items())))
    message = f"{node.name} {what}; that of the network is {reason}"
    report(rules.OTHER_SYNC.at(node.span, message))
    return node


def _is_chosen(node: BusNode, number: tuple[int, int]) -> bool:
    variable = node.device.find(*number)
    return variable is not None and variable.value is not None
