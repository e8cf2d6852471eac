"""Links in real time, over python-can's virtual bus: threads, timers, local stations, faults."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from itertools import count

import can
import pytest
from free_ports import free_port
from patience import PATIENCE
from stations import Recorder

from rtgen.runtime import RealClock
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.python_can import bus_address
from rtgen.runtime.canopen.bus.real_link import RealLink
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame

SECOND = 1_000_000_000
WAIT = 20.0
NUMBERS = count()


@pytest.fixture
def channel() -> Iterator[str]:
    yield f"test{next(NUMBERS)}"
    left = [t.name for t in threading.enumerate() if t.name.startswith("rtgen ")]
    assert not left


@pytest.fixture
def peer(channel: str) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=channel) as bus:
        yield bus


def opened(channel: str, options: str = "") -> Link:
    return open_link(RealClock(), "virtual", channel, 0, options)


def until(link: Link, condition: Callable[[], bool]) -> None:
    assert link.wait(condition, 20 * SECOND)


def message(can_id: int, data: bytes = b"") -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


def test_frames_go_both_ways(channel: str, peer: can.BusABC) -> None:
    link = opened(channel)
    station = Recorder()
    link.attach(station)
    sent = [
        Frame(0x123, b"12345678"),
        Frame(0x7FF),
        Frame(0x1FFFFFFF, b"x", extended=True),
        Frame(0x80, remote=True),
    ]
    link.send(sent, station)
    got = [peer.recv(WAIT) for _ in sent]
    for frame, one in zip(sent, got, strict=True):
        assert one is not None
        assert one.arbitration_id == frame.can_id
        assert bytes(one.data) == frame.data
        assert one.is_extended_id == frame.extended
        assert one.is_remote_frame == frame.remote
        peer.send(one)
    until(link, lambda: len(station.frames) == len(sent))
    assert station.frames == sent
    assert station.times == sorted(station.times)
    link.detach(station)


def test_what_is_no_classical_frame_is_ignored(channel: str, peer: can.BusABC) -> None:
    link = opened(channel)
    assert isinstance(link, RealLink)
    station = Recorder()
    link.attach(station)
    peer.send(can.Message(arbitration_id=1, data=bytes(12), is_fd=True, dlc=12))
    peer.send(message(2))
    until(link, lambda: bool(station.frames))
    assert (station.ids, link.ignored) == ([2], 1)
    link.detach(station)


def test_a_process_has_one_link_for_a_bus(channel: str) -> None:
    link = opened(channel)
    assert opened(channel) is link
    other = opened(channel, "rx_queue_size=0")
    assert other is not link
    a, b, c = Recorder(), Recorder(), Recorder()
    link.attach(a)
    link.attach(b)
    other.attach(c)
    link.detach(a)
    link.send([Frame(1)], b)
    until(other, lambda: c.ids == [1])
    link.detach(b)
    other.detach(c)
    with pytest.raises(LinkError, match=r"virtual test.* is closed"):
        link.attach(a)
    again = opened(channel)
    assert again is not link
    again.attach(a)
    again.detach(a)


def test_a_link_is_kept_for_who_asked_for_it(channel: str) -> None:
    first, second = opened(channel), opened(channel)
    a, b = Recorder(), Recorder()
    first.attach(a)
    first.detach(a)
    second.attach(b)
    assert second.up
    second.detach(b)


def test_stations_of_a_process_hear_each_other_once(
    channel: str, peer: can.BusABC
) -> None:
    link = opened(channel)
    a, b = Recorder(), Recorder(answer=lambda f: [Frame(9)] if f.can_id == 8 else [])
    link.attach(a)
    link.attach(b)
    link.send([Frame(8)], a)
    assert [m.arbitration_id for m in (peer.recv(WAIT), peer.recv(WAIT)) if m] == [8, 9]
    assert (a.ids, b.ids) == ([9], [8])
    assert peer.recv(0.02) is None
    assert (a.ids, b.ids) == ([9], [8])
    link.detach(a)
    link.detach(b)


def test_an_answer_does_not_overtake_its_question(
    channel: str, peer: can.BusABC
) -> None:
    link = opened(channel)
    a = Recorder(answer=lambda f: [Frame(9)] if f.can_id == 8 else [])
    b = Recorder()
    link.attach(a)
    link.attach(b)
    peer.send(message(8))
    until(link, lambda: len(b.frames) == 2)
    assert b.ids == [8, 9]
    link.detach(a)
    link.detach(b)


def test_stations_that_answer_each_other_for_ever(channel: str) -> None:
    link = opened(channel)
    a = Recorder(8, answer=lambda f: [Frame(9)])
    b = Recorder(9, answer=lambda f: [Frame(8)])
    link.attach(a)
    link.attach(b)
    link.send([Frame(8)], b)
    assert len(a.frames) > 1000
    link.detach(a)
    link.detach(b)


def test_timers(channel: str, peer: can.BusABC) -> None:
    link = opened(channel)
    producer = Recorder(1)
    producer.poll_frames = [Frame(0x80)]
    producer.period = 5_000_000
    producer.deadline = link.now()
    link.attach(producer)
    assert all(peer.recv(WAIT) for _ in range(5))
    with link.lock:
        producer.period = 0
        producer.deadline = None
        link.refresh(producer)
        polls = len(producer.polls)
    other = Recorder(2)
    other.period = 5_000_000
    other.deadline = link.now()
    link.attach(other)
    until(link, lambda: len(other.polls) >= 6)
    link.detach(other)
    assert len(producer.polls) == polls
    assert producer.polls == sorted(producer.polls)
    # A distant timer is set to an earlier time.
    with link.lock:
        producer.deadline = link.now() + 3600 * SECOND
        link.refresh(producer)
    with link.lock:
        producer.deadline = link.now()
        link.refresh(producer)
    until(link, lambda: len(producer.polls) == polls + 1)
    link.detach(producer)


def test_a_station_that_raises_stops_nobody(
    channel: str, peer: can.BusABC, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(frame: Frame) -> Iterable[Frame]:
        raise ZeroDivisionError

    link = opened(channel)
    a, b = Recorder(answer=fail), Recorder()
    link.attach(a)
    link.attach(b)
    peer.send(message(1))
    peer.send(message(2))
    until(link, lambda: b.ids == [1, 2])
    assert a.ids == [1, 2]
    assert "failed" in caplog.text
    link.detach(a)
    link.detach(b)


def test_waiting(channel: str, peer: can.BusABC) -> None:
    link = opened(channel)
    refused: list[str] = []

    def wait_inside(frame: Frame) -> Iterable[Frame]:
        try:
            link.wait(lambda: True, SECOND)
        except RuntimeError as error:
            refused.append(str(error))
        return ()

    station = Recorder(answer=wait_inside)
    link.attach(station)
    assert not link.wait(lambda: False, 1_000_000)
    peer.send(message(1))
    until(link, lambda: bool(refused))
    assert refused == ["a station must not wait for its link"]
    link.detach(station)


def test_a_station_may_leave_when_it_is_called_or_with_the_lock_held(
    channel: str, peer: can.BusABC
) -> None:
    link = opened(channel)

    def leave(frame: Frame) -> Iterable[Frame]:
        link.detach(station)
        return ()

    station = Recorder(answer=leave)
    link.attach(station)
    peer.send(message(1))
    assert isinstance(link, RealLink)
    link._threads[0].join(PATIENCE)
    assert not link._threads[0].is_alive()
    again = opened(channel)
    again.attach(station)
    with again.lock:
        again.detach(station)
    assert not again.up


def test_what_was_sent_goes_before_the_link_closes(
    channel: str, peer: can.BusABC
) -> None:
    link = opened(channel)
    station = Recorder()
    link.attach(station)
    link.send((Frame(n) for n in range(500)), station)
    link.detach(station)
    got = [peer.recv(WAIT) for _ in range(500)]
    assert [m.arbitration_id for m in got if m is not None] == list(range(500))


def test_who_sends_too_much_loses_frames(
    channel: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = opened(channel)
    assert isinstance(link, RealLink)
    go_on = threading.Event()
    assert link._bus is not None
    monkeypatch.setattr(link._bus, "send", lambda frame: go_on.wait(PATIENCE))
    station = Recorder()
    link.attach(station)
    link.send([Frame(1)] * 5000, station)
    assert 5000 - 4096 - 1 <= link.lost <= 5000 - 4096
    go_on.set()
    link.detach(station)


def test_a_bus_that_fails_is_opened_again(
    channel: str, monkeypatch: pytest.MonkeyPatch, peer: can.BusABC
) -> None:
    link = opened(channel)
    assert isinstance(link, RealLink)
    station = Recorder()
    link.attach(station)
    assert link._bus is not None

    def fail(msg: can.Message, timeout: float | None = None) -> None:
        raise can.CanOperationError("the cable is out")

    monkeypatch.setattr(link._bus.bus, "send", fail)
    link.send([Frame(1)], station)
    until(link, lambda: station.changes == [False, True])
    assert link.lost == 1
    link.send([Frame(2)], station)
    got = peer.recv(WAIT)
    assert got is not None
    assert got.arbitration_id == 2
    link.detach(station)


def test_bus_off_that_the_controller_tells(
    channel: str, monkeypatch: pytest.MonkeyPatch, peer: can.BusABC
) -> None:
    state = [can.BusState.ERROR]
    monkeypatch.setattr(
        can.interfaces.virtual.VirtualBus, "state", property(lambda self: state[0])
    )
    link = opened(channel)
    station = Recorder()
    link.attach(station)
    peer.send(can.Message(is_error_frame=True))
    until(link, lambda: station.changes == [False])
    assert not link.up
    with pytest.raises(LinkError, match="is off"):
        link.send([Frame(1)], station)
    outcomes: list[object] = []
    link.sdo(5).submit_upload(0x1000, 0, outcomes.append)
    assert isinstance(outcomes[0], LinkError)
    state[0] = can.BusState.ACTIVE
    until(link, lambda: station.changes == [False, True])
    link.send([Frame(1)], station)
    link.detach(station)


def test_bus_off_in_error_frames(channel: str) -> None:
    from rtgen.runtime.canopen.bus.python_can import OpenBus

    with can.Bus(interface="virtual", channel=channel) as bus:
        opened = OpenBus(bus, bus_address("socketcand", channel))
        tell = [
            opened.went_off(can.Message(arbitration_id=kind, is_error_frame=True))
            for kind in (0x40, 0x100, 0x4)
        ]
    assert tell == [True, False, None]


def test_bit_rates_that_differ(channel: str) -> None:
    link = open_link(RealClock(), "virtual", channel, 500_000)
    with pytest.raises(LinkError, match="is open at 500000 bit/s, and not at 250000"):
        open_link(RealClock(), "virtual", channel, 250_000)
    station = Recorder()
    link.attach(station)
    link.detach(station)


@pytest.mark.parametrize(
    ("interface", "channel", "bitrate", "options", "text"),
    [
        ("soketcan", "can0", 0, "", "no interface 'soketcan'; known: .*socketcan"),
        ("virtual", "can0", -1, "", "-1 is not a bit rate"),
        ("virtual", "", 0, "", "'' is not a channel"),
        ("virtual", "can0", 0, "host", "'host' is not an option"),
        ("virtual", "can0", 0, "bitrate=5", "bitrate is a parameter of its own"),
        ("socketcand", "can0", 0, "port=0", "0 is not a port"),
        ("socketcand", "can0", 0, "port=x", "'x' is not a port"),
        ("slcan", "/dev/none", 0, "sleep_after_open=0", "slcan /dev/none: .*No such"),
        ("socketcan", "no_such_can", 0, "", "socketcan no_such_can: "),
    ],
)
def test_what_cannot_be_opened(
    interface: str, channel: str, bitrate: int, options: str, text: str
) -> None:
    with pytest.raises(LinkError, match=text) as caught:
        open_link(RealClock(), interface, channel, bitrate, options)
    assert "\n" not in str(caught.value)


def test_options_have_types() -> None:
    address = bus_address("virtual", "c", 0, "a=1, b=0x10,c=1.5,d=True,e=can.host,")
    assert dict(address.options) == {
        "a": 1,
        "b": 16,
        "c": 1.5,
        "d": True,
        "e": "can.host",
    }


def test_no_hub() -> None:
    port = free_port()
    text = (
        f"socketcand can0 at 127.0.0.1:{port}: Connection refused; is `rtgen can hub`"
    )
    with pytest.raises(LinkError, match=text):
        open_link(RealClock(), "socketcand", "can0", 0, f"port={port}")


@pytest.mark.parametrize(
    ("greeting", "answer", "text"),
    [
        (b"HTTP/1.1 400\r\n", b"", "the hub replied 'HTTP/1.1 400"),
        (b"< hi >", b"< error no such device >", "the hub replied '< error no such"),
        (b"", b"", "the hub replied 'nothing'"),
    ],
)
def test_no_proper_hub(greeting: bytes, answer: bytes, text: str) -> None:
    def serve() -> None:
        end, _ = server.accept()
        with end:
            end.sendall(greeting)
            if answer:
                end.recv(100)
                end.sendall(answer)

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve)
        thread.start()
        port = server.getsockname()[1]
        with pytest.raises(LinkError, match=text):
            open_link(RealClock(), "socketcand", "can0", 0, f"port={port}")
        thread.join()
