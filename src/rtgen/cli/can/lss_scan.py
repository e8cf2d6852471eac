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
    select,
    switch,
)

_MAX_NODES = 127
_TRIES = 3
"""An answer that comes too late on a busy machine spoils a search, so one is not enough."""


def unconfigured(exchange: Exchange) -> list[LssAddress]:
    """The addresses of the nodes without node-id, which are left as they were. Raises ToolError.

    A node that was found is in configuration state, so the next scan finds another. A late answer
    makes a scan find an address that no node has: so each is confirmed by selecting it.
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
    tries = _TRIES
    while tries and len(found) < _MAX_NODES:
        address = yield from scan()
        if address is None:
            tries -= 1
        elif address in found:
            break
        else:
            found.append(address)
            tries = _TRIES
    confirmed = []
    for address in found:
        yield switch(lss.WAITING)
        if (yield from select(address)):
            confirmed.append(address)
    yield switch(lss.WAITING)
    return confirmed
