"""Locates a proxy's node in a network, with defaults from the device description."""

from __future__ import annotations

from typing import Final

from rtgen.facts.cob_ids import COB_ID_EMERGENCY, COB_ID_SYNC
from rtgen.runtime.canopen.description import (
    DeviceDescription,
    Network,
    NodeDescription,
)
from rtgen.runtime.canopen.master.node_control import NodeError
from rtgen.runtime.canopen.networks import UnknownNetworkError, load_network
from rtgen.runtime.canopen.wire.frames import CobId

BOOT_TIMEOUT: Final = 2000
"""Default of the parameter `boot_timeout` in ms; overridden by the network, or by 1F89h."""
_BOOT_TIME: Final = (0x1F89, 0)


def place(
    networks: str, name: str, node_id: int, module: str
) -> tuple[Network | None, NodeDescription | None]:
    """Find a network by name, and the node in it; (None, None) for an empty name.

    `networks` is the package of the generated networks, `module` that of the device. Raises
    NodeError if either is unknown, or the node is of another kind.
    """
    if not name:
        return None, None
    try:
        network = load_network(networks, name)
    except UnknownNetworkError as error:
        raise NodeError(str(error)) from None
    node = network.node(node_id)
    if node is None:
        raise NodeError(f"the network {name} has no node {node_id}")
    if node.module != module:
        raise NodeError(
            f"node {node.id} of the network {name} is not a {module}, but {node.module}"
        )
    return network, node


def default_boot_timeout(
    description: DeviceDescription, placed: NodeDescription | None
) -> int:
    """Return the boot time-out in ms: the network's, else the device's 1F89h, else 2 s.

    1F89h is defined by CiA 302-2.
    """
    if placed is not None:
        return placed.boot_timeout
    return description.initial_number(_BOOT_TIME, 0) or BOOT_TIMEOUT


def cob_ids(
    description: DeviceDescription,
    node_id: int,
    network: Network | None,
    placed: NodeDescription | None,
) -> tuple[CobId, CobId]:
    """Return the COB-IDs of SYNC and of the node's emergencies."""
    if network is None or placed is None:
        return (
            CobId(description.cob_id(COB_ID_SYNC, node_id)),
            CobId(description.cob_id(COB_ID_EMERGENCY, node_id)),
        )
    return CobId(network.sync_cob_id), CobId(placed.emergency_cob_id)
