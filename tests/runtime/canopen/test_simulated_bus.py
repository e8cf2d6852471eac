"""The CAN bus of simulated time: order, times, timers, dispatch, faults."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from stations import Recorder

from rtgen.runtime import RTC_OK, Component, ReturnCode_t, SimulatedClock, System
from rtgen.runtime.canopen.bus.arbitration import transmission_time
from rtgen.runtime.canopen.bus.links import open_link, simulated_bus
from rtgen.runtime.canopen.bus.simulated_bus import SimulatedCanBus
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame

MS = 1_000_000


@pytest.fixture
def system() -> Iterable[System]:
    with System() as system:
        yield system


def bus_of(system: System, bitrate: int = 0) -> SimulatedCanBus:
    assert system.clock.network is not None
    return simulated_bus(system.clock.network, "can0", bitrate)


def attach(bus: SimulatedCanBus, *stations: Recorder) -> None:
    for station in stations:
        bus.attach(station)


def test_a_channel_is_one_bus(system: System) -> None:
    link = open_link(system.clock, "virtual", "can0")
    component = Component("one")
    system.add(component)
    assert open_link(component, "socketcan", "can0", 0, "x=1") is link
    assert open_link(component, channel="can1") is not link


def test_a_bus_has_one_bit_rate(system: System) -> None:
    open_link(system.clock)
    open_link(system.clock, bitrate=500_000)
    open_link(system.clock)
    with pytest.raises(LinkError, match="at 500000 bit/s, and not at 250000 bit/s"):
        open_link(system.clock, bitrate=250_000)


def test_a_bus_needs_a_system() -> None:
    with pytest.raises(LinkError, match="no system runs on its clock"):
        open_link(SimulatedClock())


def test_all_but_the_sender_get_a_frame_in_the_order_of_attachment(
    system: System,
) -> None:
    bus = bus_of(system)
    order: list[int] = []

    def noted(number: int) -> Recorder:
        def answer(frame: Frame) -> Iterable[Frame]:
            order.append(number)
            return ()

        return Recorder(answer=answer)

    stations = [noted(number) for number in range(4)]
    attach(bus, *stations)
    bus.send([Frame(5, b"x")], stations[2])
    system.run(1)
    assert order == [0, 1, 3]
    assert stations[0].frames == [Frame(5, b"x")]
    assert stations[2].frames == []


def test_frames_of_one_instant_compete_by_identifier(system: System) -> None:
    bus = bus_of(system)
    a, b, monitor = Recorder(1), Recorder(1), Recorder()
    attach(bus, a, b, monitor)
    system.at(5, lambda: bus.send([Frame(0x300), Frame(0x100)], a))
    system.at(5, lambda: bus.send([Frame(0x200)], b))
    system.run(10)
    assert monitor.ids == [0x200, 0x300, 0x100]
    assert monitor.times == [5, 5, 5]


def test_ticks_of_one_instant_compete_too(system: System) -> None:
    bus = bus_of(system, 125_000)

    class Sender(Component):
        station = Recorder(1)

        def on_execute(self, ec_id: int) -> ReturnCode_t:
            bus.send([Frame(int(self.instance_name, 16))], self.station)
            return RTC_OK

    monitor = Recorder()
    bus.attach(monitor)
    for name in ("300", "100", "200"):
        sender = Sender(name)
        sender.station = Recorder(1)
        bus.attach(sender.station)
        system.add(sender, 10.0)
        system.activate(name)
    system.run(90 * MS)
    assert monitor.ids == [0x100, 0x200, 0x300]
    times = [transmission_time(frame, 125_000) for frame in monitor.frames]
    assert monitor.times == [times[0], sum(times[:2]), sum(times)]


def test_a_frame_that_is_under_way_is_not_overtaken(system: System) -> None:
    bus = bus_of(system, 1_000_000)
    a, b, monitor = Recorder(1), Recorder(1), Recorder()
    attach(bus, a, b, monitor)
    bus.send([Frame(0x700), Frame(0x600)], a)
    system.at(10_000, lambda: bus.send([Frame(0x001)], b))
    system.run(MS)
    assert monitor.ids == [0x700, 0x001, 0x600]


def test_answers_take_part_at_once(system: System) -> None:
    bus = bus_of(system)

    def count_down(frame: Frame) -> Iterable[Frame]:
        return [Frame(frame.can_id - 1)] if frame.can_id > 1 else []

    a, b = Recorder(answer=count_down), Recorder(answer=count_down)
    attach(bus, a, b)
    bus.send([Frame(6)])
    system.run(1)
    assert a.ids == b.ids == [6, 5, 4, 3, 2, 1]


def test_dispatch_by_identifier_follows_changes(system: System) -> None:
    bus = bus_of(system)
    a, b = Recorder(0x10), Recorder(0x11)
    attach(bus, a, b)
    bus.send([Frame(0x10), Frame(0x11), Frame(0x12)])
    system.run(1)
    assert (a.ids, b.ids) == ([0x10], [0x11])
    a.identifiers = frozenset((0x12,))
    bus.refresh(a)
    bus.send([Frame(0x10), Frame(0x11), Frame(0x12)])
    system.run(2)
    assert (a.ids, b.ids) == ([0x10, 0x12], [0x11, 0x11])


def test_timers_run_by_the_clock(system: System) -> None:
    bus = bus_of(system)
    producer, monitor = Recorder(1), Recorder()
    producer.poll_frames = [Frame(0x80)]
    producer.period = 10 * MS
    producer.deadline = 3 * MS
    attach(bus, producer, monitor)
    system.run(35 * MS)
    assert producer.polls == [3 * MS, 13 * MS, 23 * MS, 33 * MS]
    assert monitor.times == producer.polls


def test_a_deadline_that_comes_forward_or_goes_back(system: System) -> None:
    bus = bus_of(system)
    station = Recorder(1)
    attach(bus, station)

    def due(instant: int | None) -> None:
        station.deadline = instant
        bus.refresh(station)

    due(50 * MS)
    system.at(1 * MS, lambda: due(20 * MS))
    system.at(10 * MS, lambda: due(30 * MS))
    system.at(40 * MS, lambda: due(45 * MS))
    system.at(41 * MS, lambda: due(None))
    system.run(100 * MS)
    assert station.polls == [30 * MS]


def test_who_is_still_due_does_not_stop_time(system: System) -> None:
    class Stuck(Recorder):
        def poll(self, now: int) -> Iterable[Frame]:
            self.polls.append(now)
            return ()

    bus = bus_of(system)
    station = Stuck()
    station.deadline = 0
    attach(bus, station)
    system.run(3 * MS)
    assert station.polls == [0, MS, 2 * MS]


def test_a_storm_does_not_stop_time(system: System) -> None:
    bus = bus_of(system)
    a = Recorder(0x10, answer=lambda frame: [Frame(0x11)])
    b = Recorder(0x11, answer=lambda frame: [Frame(0x10)])
    attach(bus, a, b)
    bus.send([Frame(0x10)], b)
    system.run(MS)
    assert len(a.frames) > 10_000
    assert system.time == MS


def test_who_floods_the_bus_loses_frames(system: System) -> None:
    bus = bus_of(system, 10_000)
    a, monitor = Recorder(1), Recorder()
    attach(bus, a, monitor)
    bus.send([Frame(0x100)] * 20_000, a)
    assert bus.lost == 20_000 - 16_384


def test_waiting_lets_frames_go_without_time(system: System) -> None:
    bus = bus_of(system, 10_000)
    server = Recorder(0x601, answer=lambda frame: [Frame(0x581, frame.data)])
    client = Recorder(0x581)
    attach(bus, server, client)
    bus.send([Frame(0x601, b"1"), Frame(0x601, b"2")], client)
    assert bus.wait(lambda: len(client.frames) == 2, 10 * MS)
    assert system.time == 0
    assert not bus.wait(lambda: len(client.frames) == 3, 10 * MS)
    system.run(100 * MS)
    assert len(client.frames) == 2


def test_bus_off_and_return(system: System) -> None:
    bus = bus_of(system, 10_000)
    a, b = Recorder(), Recorder()
    attach(bus, a, b)
    bus.send([Frame(1), Frame(2)], a)
    system.run(1)
    bus.cut()
    assert not bus.up
    with pytest.raises(LinkError, match="the simulated bus can0 is off"):
        bus.send([Frame(3)], a)
    system.run(100 * MS)
    assert b.frames == []
    bus.mend()
    bus.send([Frame(4)], a)
    system.run(200 * MS)
    assert b.ids == [4]
    assert a.changes == b.changes == [False, True]


def test_one_station_is_cut_off(system: System) -> None:
    bus = bus_of(system)
    a, b, c = Recorder(), Recorder(), Recorder()
    b.poll_frames = [Frame(9)]
    b.deadline = 5
    attach(bus, a, b, c)
    bus.cut(b)
    bus.send([Frame(1)], a)
    with pytest.raises(LinkError):
        bus.send([Frame(2)], b)
    system.run(10)
    assert bus.up
    assert (b.changes, b.frames, c.ids, b.polls) == ([False], [], [1], [5])
    assert bus.lost == 1
    bus.mend(b)
    bus.send([Frame(3)], a)
    system.run(20)
    assert (b.changes, b.ids, a.changes) == ([False, True], [3], [])


def test_disturbed_frames(system: System) -> None:
    def disturbance(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
        if frame.can_id == 1:
            return []
        if frame.can_id == 2:
            return [(7 * MS, frame)]
        return [(0, frame), (0, Frame(frame.can_id, b"again"))]

    bus = bus_of(system)
    monitor = Recorder()
    attach(bus, monitor)
    bus.disturbance = disturbance
    bus.send([Frame(1), Frame(2), Frame(3)])
    system.run(10 * MS)
    assert monitor.frames == [Frame(3), Frame(3, b"again"), Frame(2)]
    assert monitor.times == [0, 0, 7 * MS]


def test_what_a_station_sent_before_it_left_still_goes(system: System) -> None:
    bus = bus_of(system)
    a, b = Recorder(), Recorder()
    attach(bus, a, b)
    bus.send([Frame(1)], a)
    bus.detach(a)
    bus.detach(a)
    bus.send([Frame(2)], b)
    system.run(1)
    assert (a.frames, b.ids) == ([], [1])


def test_a_station_is_attached_once(system: System) -> None:
    bus = bus_of(system)
    station = Recorder()
    bus.attach(station)
    with pytest.raises(ValueError, match="attached already"):
        bus.attach(station)


def test_sdo_over_the_bus_and_its_end(system: System) -> None:
    bus = bus_of(system)
    station = Recorder(0x601)
    bus.attach(station)
    channel = bus.sdo(1)
    assert bus.sdo(1) is channel
    outcomes: list[object] = []
    channel.submit_upload(0x1000, 0, outcomes.append)
    system.run(1)
    assert station.frames == [Frame(0x601, bytes([0x40, 0, 0x10, 0, 0, 0, 0, 0]))]
    bus.detach(station)
    assert isinstance(outcomes[0], LinkError)
    bus.attach(station)
    assert bus.sdo(1) is not channel


def test_runs_are_equal() -> None:
    def run() -> list[tuple[int, int]]:
        with System() as system:
            bus = bus_of(system, 250_000)
            monitor = Recorder()
            bus.attach(monitor)
            for number in range(30):
                producer = Recorder(1)
                producer.poll_frames = [
                    Frame(0x200 + 37 * number % 30, bytes(number % 9))
                ]
                producer.period = (number % 5 + 1) * MS
                producer.deadline = 0
                bus.attach(producer)
            system.run(50 * MS)
            return list(zip(monitor.times, monitor.ids, strict=True))

    first = run()
    assert len(first) > 150
    assert first == run()
