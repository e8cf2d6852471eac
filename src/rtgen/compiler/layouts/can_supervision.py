"""Supervision of a network's nodes: by heartbeat, falling back to node guarding.

Times are in ms, 0 for none.
"""

from __future__ import annotations

from rtgen.compiler.model.can_bus import BusNode

_GUARD_TIME, _LIFE_TIME_FACTOR, _HEARTBEAT = 0x100C, 0x100D, 0x1017
_PERIODS = 3
"""A node is lost when this number of heartbeats, or guarding answers, is missing."""


def heartbeat(node: BusNode) -> int:
    """Return the period of a node's heartbeat."""
    return node.device.number(_HEARTBEAT) or 0


def guard_time(node: BusNode) -> int:
    """Return the period at which a node without heartbeat is polled."""
    return 0 if heartbeat(node) else node.device.number(_GUARD_TIME) or 0


def heartbeat_timeout(node: BusNode) -> int:
    """Return the time without heartbeat or guarding answer after which a node is lost.

    0: unsupervised.
    """
    period = heartbeat(node) or guard_time(node)
    if period and node.heartbeat_timeout is not None:
        return round(node.heartbeat_timeout * 1000)
    if heartbeat(node):
        return _PERIODS * period
    return (node.device.number(_LIFE_TIME_FACTOR) or _PERIODS) * period
