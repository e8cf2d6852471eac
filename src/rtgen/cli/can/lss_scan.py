"""Nodes without node-id, as LSS fastscan finds them (CiA 305)."""

from __future__ import annotations

import time

from rtgen.cli.can.exchange import Exchange
from rtgen.runtime.canopen import lss
from rtgen.runtime.canopen.lss import LssAddress
from rtgen.runtime.canopen.lss_master import (
    LssError,
    LssMaster,
    Procedure,
    scan,
    switch,
)

_MAX_NODES = 127


def unconfigured(exchange: Exchange) -> list[LssAddress]:
    """The addresses of the nodes without node-id, which are left as they were. Raises ToolError.

    A node that was found is in configuration state, so the next scan finds another.
    """
    master = LssMaster()
    outcomes: list[list[LssAddress] | LssError] = []
    exchange.send(master.submit(_all(), outcomes.append, time.monotonic_ns()))
    exchange.run([master])
    found = outcomes[0]
    assert not isinstance(found, LssError)
    return found


def _all() -> Procedure[list[LssAddress]]:
    yield switch(lss.WAITING)
    found: list[LssAddress] = []
    while len(found) < _MAX_NODES:
        address = yield from scan()
        if address is None or address in found:
            break
        found.append(address)
    yield switch(lss.WAITING)
    return found
