"""Each fault at each step: of SDO transfers, and of the boot of a node."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from fault_table import bound
from sdo_line import LOST, MS, ONCE, TWICE, Line, Values, line
from slaves import Slave
from test_manager_station import HEARTBEAT, VALUE, Bench, described

from rtgen.runtime.canopen.description import Write
from rtgen.runtime.canopen.master.managed_node import NodePhase
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtState
from rtgen.runtime.canopen.wire.sdo import SdoAbort

OLD, NEW = b"old" * 30, bytes(range(200))
WAYS = [(write, block) for write in (False, True) for block in (False, True)]
LATE, CORRUPT, RESET = "late", "corrupt", "reset"


class FaultyLine(Line):
    """A line on which one frame of a transfer is late, has a wrong octet, or resets the server."""

    fault = ""
    place = 0
    _held: Frame | None = None

    def _deliver(self, frame: Frame) -> None:
        self.place -= 1
        if self.place == 0 and self.fault == RESET:
            self.server.reset()
        elif self.place == 0 and self.fault == CORRUPT:
            data = bytes((frame.data[0] ^ 0x10,)) + frame.data[1:]
            frame = Frame(frame.can_id, data)
        elif self.place == 0 and self.fault == LATE:
            self._held = frame
            return
        super()._deliver(frame)

    def _send(self, frames: list[Frame]) -> None:
        super()._send(frames)
        # After the time-out of the waiting end, its abort is under way: only now the late frame
        # comes.
        if self._held is not None and any(frame.data[0] == 0x80 for frame in frames):
            held, self._held = self._held, None
            super()._send([held])


def transfer(wire: Line, write: bool, block: bool) -> bytes | SdoAbort:
    """Return the outcome of one transfer."""
    client, now = wire.client, wire.now
    try:
        if write:
            return wire.run(client.download(0x2000, 0, NEW, now, block=block))
        return wire.run(client.upload(0x2000, 0, now, block=block))
    except SdoAbort as abort:
        return abort


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("write", "block"), WAYS)
@pytest.mark.parametrize("fault", [LOST, TWICE, LATE, CORRUPT, RESET])
def test_a_fault_at_each_frame_of_a_transfer(
    fault: int | str, write: bool, block: bool
) -> None:
    sound = line(Values(OLD), block_size=8)
    transfer(sound, write, block)
    for place in range(1, len(sound.frames) + 1):
        values = Values(OLD)
        plain = line(values, block_size=8)
        wire = FaultyLine(plain.client, plain.server)
        if isinstance(fault, int):
            wire._fates.extend([ONCE] * (place - 1) + [fault])
        else:
            wire.fault, wire.place = fault, place
        outcome = transfer(wire, write, block)
        assert wire.now <= bound("sdo")
        # The object has its old value or the new one, and the error says that it may be the old
        # one.
        assert values.value in (OLD, NEW)
        assert len(values.writes) <= 1
        if not isinstance(outcome, SdoAbort):
            assert values.value == (NEW if write else OLD)
            assert write or outcome == OLD
        # The next transfer is not disturbed by frames of this one.
        again = line(values)
        again.client, again.server, again.now = wire.client, wire.server, wire.now
        assert again.run(again.client.upload(0x2000, 0, again.now)) == values.value


CONFIGURATION = (HEARTBEAT, Write(0x2003, 0, bytes(range(40))), Write(0x2002, 0, VALUE))


class BootFault:
    """Applies a fault to the frame of that number between manager and node."""

    def __init__(self, kind: str, place: int, bench: Bench) -> None:
        self.kind = kind
        self.place = place
        self.seen = 0
        self.bench = bench
        bench.bus.disturbance = self

    def __call__(self, frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
        self.seen += 1
        if self.seen != self.place:
            return [(0, frame)]
        match self.kind:
            case "lost":
                return []
            case "doubled":
                return [(0, frame), (0, frame)]
            case "late":
                return [(400 * MS, frame)]
            case "corrupted":
                data = frame.data[:-1] + bytes((frame.data[-1] ^ 0xFF,))
                return [(0, Frame(frame.can_id, data))] if frame.data else []
            case _:
                slave: Slave = self.bench.slaves[5]
                slave.power_on(now)
                self.bench.bus.refresh(slave)
                return [(0, frame)]


def boot(kind: str, place: int) -> tuple[Bench, BootFault]:
    """Return a node that is booted by its manager, with a fault at one frame."""
    bench = Bench(described(configuration=CONFIGURATION, restarts=3))
    bench.slave()
    fault = BootFault(kind, place, bench)
    bench.start(bound("boot") / 1e9)
    return bench, fault


@pytest.mark.sampled(1)
@pytest.mark.parametrize("kind", ["lost", "doubled", "late", "corrupted", "reset"])
def test_a_fault_at_each_frame_of_a_boot(kind: str) -> None:
    bench, fault = boot(kind, 0)
    first = next(
        number
        for number, frame in enumerate(bench.frames.frames, 1)
        if frame.can_id == 0x705 and frame.data == b"\x05"
    )
    for place in range(1, first + 1):
        bench, fault = boot(kind, place)
        assert fault.seen >= place
        node, slave = bench.node(), bench.slaves[5]
        if kind == "corrupted" and node.phase is NodePhase.FAILED:
            # A wrong identity or value that passes CAN's check sum is that of a defective node.
            assert node.reason
            assert slave.nmt.state is not NmtState.OPERATIONAL
            continue
        assert node.phase is NodePhase.RUNNING, (place, node.reason)
        assert slave.nmt.state is NmtState.OPERATIONAL
        for write in CONFIGURATION:
            assert slave.values[write.index, write.subindex] == write.value, place
