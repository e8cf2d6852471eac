"""python-can's readers, loggers and cyclic tasks on a bus in simulated time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from stations import Recorder

from rtgen.runtime import System
from rtgen.runtime.canopen.bus.links import simulated_bus
from rtgen.runtime.canopen.bus.simulated_bus import SimulatedCanBus
from rtgen.runtime.canopen.bus.simulated_can import SimulatedBus
from rtgen.runtime.canopen.wire.frames import Frame

MS = 1_000_000


@pytest.fixture
def system() -> Iterator[System]:
    threads = threading.active_count()
    with System() as system:
        yield system
    assert threading.active_count() == threads


def link_of(system: System) -> SimulatedCanBus:
    assert system.clock.network is not None
    return simulated_bus(system.clock.network, "can0")


def message(can_id: int, data: bytes = b"") -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


def test_messages_go_both_ways(system: System) -> None:
    station = Recorder(answer=lambda frame: [Frame(frame.can_id + 1, frame.data)])
    link_of(system).attach(station)
    with SimulatedBus(system.clock) as bus:
        assert bus.recv(1.0) is None
        system.at(5 * MS, lambda: bus.send(message(0x10, b"abc")))
        system.run(10 * MS)
        assert station.frames == [Frame(0x10, b"abc")]
        got = bus.recv(None)
        assert got is not None
        assert (got.arbitration_id, bytes(got.data), got.timestamp) == (
            0x11,
            b"abc",
            0.005,
        )
        assert got.is_rx
        assert bus.recv() is None
        bus.send(message(0x20))
        got = bus.recv()
        assert got is not None
        assert got.arbitration_id == 0x21
        bus.set_filters([{"can_id": 0x31, "can_mask": 0x7FF}])
        bus.send(message(0x30))
        bus.send(message(0x40))
        got = bus.recv()
        assert got is not None
        assert got.arbitration_id == 0x31
        assert bus.recv() is None
    with pytest.raises(can.CanOperationError, match="classical"):
        bus.send(can.Message(is_fd=True))


def test_two_buses_and_no_echo(system: System) -> None:
    with SimulatedBus(system.clock) as a, SimulatedBus(system.clock) as b:
        a.send(message(1))
        assert a.recv() is None
        got = b.recv()
        assert got is not None
        assert got.arbitration_id == 1


def test_a_logger_takes_every_frame_with_its_time(
    system: System, tmp_path: Path
) -> None:
    producer = Recorder(1)
    producer.poll_frames = [Frame(0x181, b"\1\2")]
    producer.period = 10 * MS
    producer.deadline = 0
    link_of(system).attach(producer)
    with SimulatedBus(system.clock) as bus:
        logger = can.Logger(tmp_path / "run.log")
        reader = can.BufferedReader()
        bus.add_listener(logger)
        bus.add_listener(reader)
        system.run(50 * MS)
        logger.stop()
        bus.remove_listener(logger)
    with can.LogReader(tmp_path / "run.log") as log:
        times = [round(one.timestamp, 6) for one in log]
    assert times == [0.0, 0.01, 0.02, 0.03, 0.04]
    got = reader.get_message(0)
    assert got is not None
    assert bytes(got.data) == b"\1\2"


def test_cyclic_tasks_run_on_the_clock(system: System) -> None:
    monitor = Recorder()
    link_of(system).attach(monitor)
    with SimulatedBus(system.clock) as bus:
        task = bus.send_periodic(message(0x80), 0.01)
        assert isinstance(task, can.broadcastmanager.ModifiableCyclicTaskABC)
        limited = bus.send_periodic(
            [message(0x90, b"a"), message(0x90, b"b")], 0.004, duration=0.01
        )
        system.run(25 * MS)
        syncs = [
            t for t, i in zip(monitor.times, monitor.ids, strict=True) if i == 0x80
        ]
        assert syncs == [0, 10 * MS, 20 * MS]
        assert [f.data for f in monitor.frames if f.can_id == 0x90] == [
            b"a",
            b"b",
            b"a",
        ]
        task.modify_data(message(0x80, b"\5"))
        system.run(35 * MS)
        assert monitor.frames[-1] == Frame(0x80, b"\5")
        task.stop()
        limited.stop()
        count = len(monitor.frames)
        system.run(60 * MS)
        assert len(monitor.frames) == count
        with pytest.raises(ValueError, match="a period of 0 s"):
            bus.send_periodic(message(0x80), 0)


def test_bus_off(system: System) -> None:
    link = link_of(system)
    with SimulatedBus(system.clock) as bus:
        link.cut()
        assert bus.state is can.BusState.ERROR
        with pytest.raises(can.CanOperationError, match="is off"):
            bus.send(message(1))
        link.mend()
        assert bus.state is can.BusState.ACTIVE
        bus.send(message(1))
