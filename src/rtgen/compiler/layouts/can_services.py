"""The identifiers of a network's services other than PDOs and SDO."""

from __future__ import annotations

from rtgen.compiler.model.can_bus import BusNode
from rtgen.compiler.model.canopen import cob_id_in_force, resolved
from rtgen.facts.canopen import MAX_SYNC_CYCLIC
from rtgen.facts.cob_ids import COB_ID_EMERGENCY, COB_ID_SYNC

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
    return any(
        pdo.valid
        and pdo.transmission_type is not None
        and (
            pdo.transmission_type <= MAX_SYNC_CYCLIC
            or pdo.transmission_type == _RTR_SYNC
        )
        for pdo in node.device.pdos
    )


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
