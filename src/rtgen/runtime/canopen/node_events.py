"""What a slave tells its application."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rtgen.runtime.canopen.heartbeat import HeartbeatEvent
from rtgen.runtime.canopen.nmt import Transition


@dataclass
class NodeEvents:
    """What a node tells its application, in calls from the link.

    `moved`: a transition of its NMT state. `loaded`: the objects of these indices have their
    defaults again. `received`: the values of an RPDO are in the object dictionary. `heard`: news
    of a node that it watches. `time`: a TIME message, in ns of UTC. `collided`: another node has
    its node-id, or sends one of its identifiers. `bit_rate`: LSS activates a bit rate, in kbit/s,
    after a delay in ms. `stopping`: see `NmtSlave`. `ready` says whether the node may boot at once
    after a reset; if not, its owner calls `boot`.
    """

    moved: Callable[[Transition], None] = lambda transition: None
    loaded: Callable[[range], None] = lambda indices: None
    received: Callable[[int], None] = lambda number: None
    heard: Callable[[int, HeartbeatEvent], None] = lambda node_id, event: None
    time: Callable[[int], None] = lambda moment: None
    collided: Callable[[int], None] = lambda can_id: None
    bit_rate: Callable[[int, int], None] = lambda bit_rate, delay: None
    stopping: Callable[[], bool] = lambda: True
    ready: Callable[[], bool] = lambda: True
