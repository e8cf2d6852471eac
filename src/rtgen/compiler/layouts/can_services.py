"""The identifiers of a network's services other than PDOs and SDO."""

from __future__ import annotations

from rtgen.compiler.model.can_bus import BusNode
from rtgen.compiler.model.canopen import Pdo, cob_id_in_force, resolved
from rtgen.facts.canopen import MAX_SYNC_CYCLIC, NO_RTR
from rtgen.facts.cob_ids import COB_ID_EMERGENCY, COB_ID_SYNC
from rtgen.facts.write_order import PERIOD

_RTR_SYNC = 252
"""The transmission type of TPDOs that are sampled at SYNC, and sent on request."""


def emergency_cob_id(node: BusNode) -> int:
    """Return the COB-ID of a node's emergencies; the predefined one without 1014h."""
    return _cob_id(node, COB_ID_EMERGENCY)


def sync_cob_id(node: BusNode) -> int:
    """Return the COB-ID of SYNC in a node; the predefined one without 1005h."""
    return _cob_id(node, COB_ID_SYNC)


def uses_sync(node: BusNode) -> bool:
    """Return whether a valid PDO of a node depends on SYNC."""
    return any(map(waits_for_sync, node.device.pdos))


def waits_for_sync(pdo: Pdo) -> bool:
    """Return whether a PDO is valid, and its values are sent or taken with SYNC."""
    kind = pdo.transmission_type
    return (
        pdo.valid
        and kind is not None
        and (kind <= MAX_SYNC_CYCLIC or kind == _RTR_SYNC)
    )


def produces_sync(node: BusNode) -> bool:
    """Return whether a node sends SYNC: 1005h says so, and 1006h is not 0."""
    return bool(sync_cob_id(node) & NO_RTR and node.device.number(*PERIOD))


def _cob_id(node: BusNode, number: tuple[int, int]) -> int:
    variable = node.device.find(*number)
    number_in_force = (
        cob_id_in_force(number, None, node.id)
        if variable is None
        else variable.in_force(node.id)
    )
    cob_id = resolved(number_in_force, node.id)
    assert isinstance(cob_id, int)
    return cob_id
