"""126 slaves and the manager on one bus: they boot, are configured, and lose nothing."""

from __future__ import annotations

import pytest
from full_network import HEARD, SLAVES, FullNetwork

from rtgen.runtime.canopen.master.managed_node import NodePhase
from rtgen.runtime.canopen.wire.nmt import NmtState


@pytest.mark.nightly
def test_a_minute_of_a_full_bus() -> None:
    """SYNC each 100 ms, heartbeats each second, 1 Mbit/s; two runs are equal, bit for bit."""
    network, again = FullNetwork(), FullNetwork()
    network.run(3)
    assert network.phases == {NodePhase.RUNNING}
    for slave in network.slaves:
        # Each slave receives from another one, as set by its configuration.
        assert slave.node.state is NmtState.OPERATIONAL
        assert slave.node.get(HEARD, 1) == (slave.node.node_id - 2) % SLAVES + 1
    network.run(63)
    assert network.phases == {NodePhase.RUNNING}
    assert network.lost_or_doubled() == 0
    assert min(map(len, network.collector.samples.values())) >= 610
    assert min(len(slave.heard) for slave in network.slaves) >= 600
    assert not any(node.reason for node in network.manager.nodes.values())
    assert network.bus.lost == 0
    again.run(63)
    assert again.collector.frames == network.collector.frames
    assert again.collector.sum == network.collector.sum
