"""Finds nodes without a node-id by LSS fastscan (CiA 305)."""

from __future__ import annotations

import time

from rtgen.runtime.canopen.wire import lss
from rtgen.runtime.canopen.wire.lss import LssAddress
from rtgen.runtime.canopen.wire.lss_master import (
    LssError,
    LssMaster,
    Procedure,
    scan,
    select,
    switch,
)
from rtgen.tools.can.live.bus_session import BusSession

_MAX_NODES = 127
_TRIES = 3
"""Attempts per search: on a busy machine, a late response spoils one."""


def unconfigured(session: BusSession) -> list[LssAddress]:
    """Find all nodes without a node-id, which stay unconfigured. Raises ToolError.

    A node that was found stays in configuration state, so that the next scan finds another one. A
    late answer can lead a scan to an address that no node has; each address is therefore
    confirmed by selecting its node.
    """
    master = LssMaster()
    outcomes: list[list[LssAddress] | LssError] = []
    session.send(master.submit(_all(), outcomes.append, time.monotonic_ns()))
    session.run([master])
    outcome = outcomes[0]
    assert not isinstance(outcome, LssError)
    return outcome


def _all() -> Procedure[list[LssAddress]]:
    yield switch(lss.WAITING)
    addresses: list[LssAddress] = []
    tries = _TRIES
    while tries and len(addresses) < _MAX_NODES:
        address = yield from scan()
        if address is None:
            tries -= 1
        elif address in addresses:
            break
        else:
            addresses.append(address)
            tries = _TRIES
    confirmed = []
    for address in addresses:
        yield switch(lss.WAITING)
        if (yield from select(address)):
            confirmed.append(address)
    yield switch(lss.WAITING)
    return confirmed
