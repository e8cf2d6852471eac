"""Events that a slave reports to its application."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from rtgen.runtime.canopen.description import ObjectNumber
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatEvent
from rtgen.runtime.canopen.wire.nmt import Transition
from rtgen.runtime.canopen.wire.sdo import SdoAbort


class NodeEvents(msgspec.Struct):
    """Callbacks of a node to its application, called from the link.

    `moved`: a transition of its NMT state. `loaded`: these indices were reset to their defaults.
    `received`: the values of an RPDO are in the object dictionary. `refused`: an object refuses its
    value of the RPDO that is received next. `heard`: a heartbeat event of a node that it monitors.
    `time`: a TIME message, in ns of UTC. `collided`: another node has
    its node-id, or sends one of its identifiers. `bit_rate`: LSS activates a bit rate, in kbit/s,
    after a delay in ms. `stopping`: see `NmtSlave`. `ready`: whether the node may boot
    immediately after a reset; if not, its owner calls `boot`.
    """

    moved: Callable[[Transition], None] = lambda transition: None
    loaded: Callable[[range], None] = lambda indices: None
    received: Callable[[int], None] = lambda number: None
    refused: Callable[[int, ObjectNumber, SdoAbort], None] = (
        lambda number, thing, why: None
    )
    heard: Callable[[int, HeartbeatEvent], None] = lambda node_id, event: None
    time: Callable[[int], None] = lambda moment: None
    collided: Callable[[int], None] = lambda can_id: None
    bit_rate: Callable[[int, int], None] = lambda bit_rate, delay: None
    stopping: Callable[[], bool] = lambda: True
    ready: Callable[[], bool] = lambda: True
