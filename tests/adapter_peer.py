"""A component that sends samples to an adapter, and receives those of the adapter."""

from __future__ import annotations

from typing import Any

from rtgen.runtime import Component, SimulatedClock, System


def connected(adapter: Component, check: str = "first") -> tuple[System, Any, Any]:
    """Return a system with an adapter, and the ports of a peer: to it, and from it."""
    system = System(SimulatedClock(), check_values=check)
    peer = Component("Peer0")
    out = peer.add_out_port("out", adapter.in_ports["input"].type)
    back = peer.add_in_port("in", adapter.out_ports["output"].type)
    system.add(peer, 100.0)
    system.add(adapter)
    name = adapter.instance_name
    system.connect(("Peer0", "out"), (name, "input"))
    system.connect((name, "output"), ("Peer0", "in"))
    return system, out, back
