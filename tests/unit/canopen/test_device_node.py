"""The slave's services, frame by frame: NMT gating, boot-up, heartbeat, SYNC, TIME, resets."""

from __future__ import annotations

import pytest
from device_bench import NODE_ID, Bench

from rtgen.runtime.canopen.frames import Frame
from rtgen.runtime.canopen.nmt import NmtCommand, NmtState

HEARTBEAT = 0x700 + NODE_ID
EMERGENCY = 0x80 + NODE_ID
TPDO1 = 0x180 + NODE_ID
RPDO1 = 0x200 + NODE_ID


def test_boot_up_then_pre_operational() -> None:
    bench = Bench()
    assert bench.sent == [Frame(HEARTBEAT, b"\0")]
    assert bench.node.state is NmtState.PRE_OPERATIONAL


def test_nothing_is_served_before_boot_up() -> None:
    bench = Bench(boot=False)
    assert bench.give(0x600 + NODE_ID, bytes.fromhex("4000100000000000")) == []
    assert bench.command(NmtCommand.START) == []
    assert bench.node.state is NmtState.INITIALISING


@pytest.mark.parametrize(
    ("state", "command", "pdo", "sdo"),
    [
        (NmtState.PRE_OPERATIONAL, NmtCommand.ENTER_PRE_OPERATIONAL, False, True),
        (NmtState.OPERATIONAL, NmtCommand.START, True, True),
        (NmtState.STOPPED, NmtCommand.STOP, False, False),
    ],
)
def test_nmt_state_says_which_services_there_are(
    state: NmtState, command: NmtCommand, pdo: bool, sdo: bool
) -> None:
    bench = Bench()
    bench.command(command, 0)
    assert bench.node.state is state
    bench.give(RPDO1, bytes.fromhex("0f0001000000"))
    assert bench.node.get(0x6040) == (0x0F if pdo else 0)
    bench.node.set(0x6041, 0, 0x21)
    assert [f.can_id for f in bench.flush()] == ([TPDO1] if pdo else [])
    answers = bench.give(0x600 + NODE_ID, bytes.fromhex("4000100000000000"))
    assert [f.can_id for f in answers] == ([0x580 + NODE_ID] if sdo else [])
    bench.node.add_error(0x2310)
    assert [f.can_id for f in bench.flush()] == ([EMERGENCY] if sdo else [])
    bench.node.dictionary.put((0x1017, 0), b"\x0a\0")
    assert bench.flush() == []
    beats = bench.run(0)
    assert beats == [Frame(HEARTBEAT, bytes((state,)))]
