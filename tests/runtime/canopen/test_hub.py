"""`rtgen can hub`, with the interfaces of python-can and with raw sockets as clients."""

from __future__ import annotations

import asyncio
import logging
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, suppress

import can
import pytest
from hub_process import HubProcess
from hypothesis import given, settings
from hypothesis import strategies as st
from stations import Recorder

from rtgen.cli import run
from rtgen.runtime import RealClock
from rtgen.runtime.canopen.bus import socketcand_bus
from rtgen.runtime.canopen.bus.arbitration import transmission_time
from rtgen.runtime.canopen.bus.hub import (
    MAX_CHANNELS,
    Carried,
    Hub,
    HubBus,
    HubSettings,
    Port,
    SocketcandPort,
)
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.bus.python_can import OpenBus, bus_address, open_bus
from rtgen.runtime.canopen.bus.real_link import RealLink
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import Frame

pytestmark = pytest.mark.waits

SECOND = 1_000_000_000


@pytest.fixture(autouse=True)
def quiet_python_can() -> None:
    logging.getLogger("can").setLevel(logging.CRITICAL)


@pytest.fixture(scope="module", params=["uvloop", "asyncio"])
def hub(request: pytest.FixtureRequest) -> Iterator[HubProcess]:
    options = (*["--slcan-pty"] * 3, "--slcan-channel", "serial")
    with HubProcess(*options, uvloop=request.param == "uvloop") as hub:
        yield hub


def socketcand(hub: HubProcess, channel: str) -> can.BusABC:
    return can.Bus(
        interface="socketcand",
        channel=channel,
        host=hub.host,
        port=hub.port,
        tcp_tune=True,
    )


def received(bus: can.BusABC, count: int) -> list[can.Message]:
    messages: list[can.Message] = []
    while len(messages) < count and (message := bus.recv(20)) is not None:
        messages.append(message)
    return messages


def equal(one: can.Message, other: can.Message) -> bool:
    return one.equals(other, None, check_channel=False, check_direction=False)


def message(can_id: int, data: bytes = b"") -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=False)


def until(link: Link, condition: Callable[[], bool]) -> None:
    assert link.wait(condition, 30 * SECOND)


def frames_of(end: socket.socket, count: int) -> list[str]:
    """Return the identifiers and data of frames, as a raw client reads them."""
    text = b""
    while text.count(b">") < count:
        data = end.recv(65536)
        assert data, "the hub has closed the connection"
        text += data
    return re.findall(r"< frame (\S+ )\S+( \S*) >", text.decode())


# Buses without sockets.


class FakePort(Port):
    def __init__(self, name: str, settings: HubSettings) -> None:
        super().__init__(name, settings, lambda text: None)
        self.frames: list[Frame] = []
        self.times: list[int] = []
        self.errors: list[int] = []
        self.reads = 0

    def give(self, carried: Carried) -> None:
        self.frames.append(carried.frame)
        self.times.append(time.monotonic_ns())

    def give_error(self, kind: int) -> None:
        self.errors.append(kind)

    def text_of(self, carried: Carried) -> bytes | None:
        return None

    def flush(self) -> None:
        return None

    def cut_off(self, why: str) -> None:
        raise AssertionError(why)

    def read_on(self) -> None:
        self.reads += 1


@pytest.mark.parametrize("bit_rate", [0, 1_000_000])
def test_what_waits_at_one_instant_competes(bit_rate: int) -> None:
    async def work() -> list[int]:
        settings = HubSettings(bit_rate)
        bus = HubBus("can0", settings)
        a, b, monitor = (FakePort(name, settings) for name in "abm")
        for port in (a, b, monitor):
            bus.join(port)
        for port, can_id in ((a, 0x300), (a, 0x050), (b, 0x200), (b, 0x400)):
            bus.put(port, Frame(can_id))
        while len(monitor.frames) < 4:
            await asyncio.sleep(0)
        assert [f.can_id for f in a.frames] == [0x200, 0x400]
        return [frame.can_id for frame in monitor.frames]

    assert asyncio.run(work()) == [0x200, 0x300, 0x050, 0x400]


def test_frames_take_their_time() -> None:
    frames = [Frame(0x123, bytes(8)), Frame(0x124, bytes(range(8))), Frame(0x125)]

    async def work() -> list[int]:
        settings = HubSettings(20_000)
        bus = HubBus("can0", settings)
        a, monitor = FakePort("a", settings), FakePort("m", settings)
        bus.join(monitor)
        begin = time.monotonic_ns()
        for frame in frames:
            bus.put(a, frame)
        while len(monitor.frames) < len(frames):
            await asyncio.sleep(0.001)
        return [instant - begin for instant in monitor.times]

    times = asyncio.run(work())
    lengths = [transmission_time(frame, 20_000) for frame in frames]
    least = [sum(lengths[: n + 1]) for n in range(len(frames))]
    assert all(instant >= bound for instant, bound in zip(times, least, strict=True))


def test_who_sends_more_than_may_wait_is_asked_to_stop() -> None:
    async def work() -> None:
        settings = HubSettings(queue=2)
        bus = HubBus("can0", settings)
        a = FakePort("a", settings)
        for _ in range(2):
            assert bus.has_room(a)
            bus.put(a, Frame(1))
        assert not bus.has_room(a)
        while not a.reads:
            await asyncio.sleep(0)
        assert a.reads == 1
        assert bus.has_room(a)

    asyncio.run(work())


def test_a_bus_that_is_off_carries_nothing() -> None:
    async def work() -> None:
        settings = HubSettings(200)
        bus = HubBus("can0", settings)
        a, b = FakePort("a", settings), FakePort("b", settings)
        bus.join(b)
        bus.put(a, Frame(1))
        await asyncio.sleep(0)
        bus.put(a, Frame(2))
        bus.turn(True)
        bus.put(a, Frame(3))
        await asyncio.sleep(0)
        bus.turn(False)
        bus.put(a, Frame(4))
        while not b.frames:
            await asyncio.sleep(0.001)
        assert b.frames == [Frame(4)]
        assert b.errors == [0x40, 0x100]
        assert bus.lost == 3

    asyncio.run(work())


class FakeTransport(asyncio.Transport):
    def __init__(self) -> None:
        super().__init__()
        self.written = b""
        self.aborted = False
        self.reading = True
        self.options: list[tuple[int, int, int]] = []

    def get_extra_info(self, name: str, default: object = None) -> object:
        return self if name == "socket" else ("127.0.0.1", 1)

    def setsockopt(self, level: int, option: int, value: int) -> None:
        self.options.append((level, option, value))

    def set_write_buffer_limits(
        self, high: int | None = None, low: int | None = None
    ) -> None:
        assert high == 0

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.written += data

    def pause_reading(self) -> None:
        self.reading = False

    def resume_reading(self) -> None:
        self.reading = True

    def abort(self) -> None:
        self.aborted = True


PIECES = st.lists(
    st.one_of(
        st.sampled_from(
            [b"< open can0 >", b"< rawmode >", b"< send 123 1 a >", b"< send 7 0 >"]
        ),
        st.sampled_from([b"<", b">", b" send ", b"12345678 ", b"\xff", b"9" * 300]),
        st.binary(max_size=20),
    ),
    max_size=40,
)


@given(PIECES)
@settings(deadline=None)
def test_whatever_a_client_sends_others_get_frames_only(pieces: list[bytes]) -> None:
    async def work() -> tuple[bytes, HubBus, bytes]:
        hub = Hub(HubSettings(queue=4), lambda text: None)
        rude, polite = SocketcandPort(hub), SocketcandPort(hub)
        ends = FakeTransport(), FakeTransport()
        for port, end in zip((rude, polite), ends, strict=True):
            port.connection_made(end)
            assert (socket.IPPROTO_TCP, socket.TCP_NODELAY, 1) in end.options
        polite.data_received(b"< open can0 >< rawmode >")
        polite._release()
        for piece in pieces:
            if ends[0].reading and not ends[0].aborted:
                rude.data_received(piece)
            await asyncio.sleep(0)
        for _ in range(100):
            await asyncio.sleep(0)
        if not ends[0].aborted:
            assert ends[0].reading
        assert rude._elements.waiting < 256
        bus = hub.buses["can0"]
        for port in (rude, polite):
            port.connection_lost(None)
        return ends[1].written, bus, ends[0].written

    polite, bus, rude = asyncio.run(work())
    answers = b"< hi >< ok >< ok >"
    assert polite.startswith(answers)
    frames = re.findall(rb"< frame (?:123 \S+ 0A|007 \S+ ) >", polite)
    assert polite[len(answers) :] == b"".join(frames)
    assert len(frames) == bus.carried
    assert b"frame" not in rude


def test_who_does_not_read_answers_is_cut_off() -> None:
    async def work() -> None:
        messages: list[str] = []
        hub = Hub(HubSettings(queue=4), messages.append)
        port, transport = SocketcandPort(hub), FakeTransport()
        port.connection_made(transport)
        port.pause_writing()
        port.data_received(b"< echo >" * 4)
        assert not transport.aborted
        port.resume_writing()
        port.pause_writing()
        port.data_received(b"< echo >" * 1000)
        assert transport.aborted
        assert transport.written == b"< hi >" + b"< echo >" * 8
        assert messages == ["127.0.0.1:1: cut off, it does not read"]

    asyncio.run(work())


# The program.


@pytest.mark.sampled(1)
def test_frames_of_all_kinds_between_clients(hub: HubProcess) -> None:
    with (
        socketcand(hub, "kinds") as a,
        socketcand(hub, "kinds") as b,
        socketcand(hub, "other") as other,
    ):
        sent = [
            message(0x123, b"\0\xff345678"),
            message(0x080),
            message(0x7FF, b"\x0a"),
            can.Message(arbitration_id=0x1FFFFFFF, data=b"xy"),
            can.Message(arbitration_id=0x1, is_extended_id=True),
        ]
        for one in sent:
            a.send(one)
        got = received(b, len(sent))
        for one, back in zip(sent, got, strict=True):
            assert equal(one, back)
        b.send(message(0x7))
        assert [m.arbitration_id for m in received(a, 1)] == [7]
        assert other.recv(0.05) is None
    stamps = [m.timestamp for m in got]
    assert stamps == sorted(stamps)


def test_order_and_number_are_kept(hub: HubProcess) -> None:
    with socketcand(hub, "many") as a, socketcand(hub, "many") as b:
        sent = [message(17 * n % 0x800, bytes([n & 255])) for n in range(5000)]

        def send() -> None:
            for one in sent:
                a.send(one)

        thread = threading.Thread(target=send)
        thread.start()
        got = received(b, len(sent))
        thread.join()
        assert [m.arbitration_id for m in got] == [m.arbitration_id for m in sent]
        assert a.recv(0.02) is None


def test_who_connects_to_a_busy_bus_gets_its_answers_alone(hub: HubProcess) -> None:
    ended = threading.Event()
    with hub.raw("busy") as a:

        def flood() -> None:
            while not ended.is_set():
                a.sendall(b"< send 123 2 1 2 >" * 20)
                time.sleep(0.001)

        thread = threading.Thread(target=flood)
        thread.start()
        try:
            for _ in range(5):
                with socketcand(hub, "busy") as bus:
                    assert len(received(bus, 30)) == 30
        finally:
            ended.set()
            thread.join()


def test_answers(hub: HubProcess) -> None:
    with hub.connect() as end:
        for text, answer in (
            ("< echo >", "< echo >"),
            ("< rawmode >", "< error unknown command >"),
            ("< send 123 0 >", "< error unknown command >"),
            ("< open answers >", "< ok >"),
            ("< rawmode >", "< ok >"),
            ("< rawmode >", "< ok >"),
            ("< echo >", "< echo >"),
        ):
            end.sendall(text.encode())
            assert end.recv(256).decode() == answer
    assert "refused, no frame: rawmode" in hub.error_line()
    assert "2 refused in all" in hub.error_line()


def test_a_report_has_no_control_characters_of_a_client(hub: HubProcess) -> None:
    with hub.connect() as end:
        end.sendall(b"< open hostile >< send \x1b]0;x\x07\n >")
        while b"< ok >" not in end.recv(256):
            pass
    line = hub.error_line()
    assert "refused, no frame: send \ufffd]0;x\ufffd" in line
    assert "\x1b" not in line


@pytest.mark.parametrize("name", ["a" * 33, "two words", "", "\x01"])
def test_what_is_no_channel(hub: HubProcess, name: str) -> None:
    with hub.connect() as end:
        end.sendall(f"< open {name} >".encode("latin-1"))
        with suppress(ConnectionResetError):
            assert end.recv(256) in (b"< error could not open bus >", b"")
    assert "cut off, no channel for it" in hub.error_line()


def test_what_is_no_frame_is_refused_told_and_counted(hub: HubProcess) -> None:
    with hub.raw("refused") as a, hub.raw("refused") as b:
        a.sendall(b"< send 123 4  >< send xyz 0 >< nonsense >rubbish< send 124 0 >")
        assert frames_of(b, 1) == [("124 ", " ")]
        assert re.fullmatch(
            r"rtgen can hub: 127.0.0.1:\d+ \(refused\): refused, no frame: send 123 4",
            hub.error_line(),
        )
    assert re.search(r"\(refused\): 4 refused in all", hub.error_line())


def test_what_was_sent_before_the_end_still_goes(hub: HubProcess) -> None:
    with hub.raw("short") as b:
        with hub.raw("short") as a:
            a.sendall(b"".join(b"< send %03x 0 >" % n for n in range(2000)))
        assert [int(f[0], 16) for f in frames_of(b, 2000)] == list(range(2000))


def test_who_does_not_read_is_cut_off_and_named() -> None:
    with (
        HubProcess("--queue", "32", "--quiet") as hub,
        hub.raw() as lazy,
        hub.raw() as sender,
        hub.raw() as reader,
    ):
        name = "{}:{}".format(*lazy.getsockname())
        messages: list[str] = []
        listener = threading.Thread(target=lambda: messages.append(hub.error_line()))
        listener.start()
        for _ in range(50_000):
            sender.sendall(b"< send 123 8 1 2 3 4 5 6 7 8 >" * 16)
            assert len(frames_of(reader, 16)) == 16
            if messages:
                break
        listener.join()
        assert messages == [f"rtgen can hub: {name} (can0): cut off, it does not read"]
        sender.sendall(b"< send 7ff 0 >")
        assert frames_of(reader, 1) == [("7FF ", " ")]


def test_a_short_queue_slows_a_sender_down_and_loses_nothing() -> None:
    options = ("--queue", "32", "--bitrate", "1000000")
    with HubProcess(*options) as hub, hub.raw() as a, hub.raw() as b:
        a.sendall(b"".join(b"< send %03x 0 >" % n for n in range(300)))
        assert [int(f[0], 16) for f in frames_of(b, 300)] == list(range(300))


def test_slcan_over_a_pseudo_terminal(hub: HubProcess) -> None:
    def slcan(path: str) -> can.BusABC:
        return can.Bus(
            interface="slcan", channel=path, sleep_after_open=0, bitrate=500_000
        )

    first, second, _ = hub.ptys
    with slcan(first) as a, slcan(second) as b, socketcand(hub, "serial") as c:
        frames = [
            message(0x123, b"12345678"),
            message(0x080),
            can.Message(arbitration_id=0x12345678, data=b"\xff"),
        ]
        remote = can.Message(
            arbitration_id=0x701, is_remote_frame=True, is_extended_id=False
        )
        a.send(remote)
        for one in frames:
            a.send(one)
        for bus, expected in ((b, [remote, *frames]), (c, frames)):
            for one, back in zip(expected, received(bus, len(expected)), strict=True):
                assert equal(one, back)
        c.send(message(0x5, b"\1"))
        assert [m.arbitration_id for m in received(a, 1)] == [5]
        assert [m.arbitration_id for m in received(b, 1)] == [5]


def test_commands_of_slcan(hub: HubProcess) -> None:
    import serial

    with serial.Serial(hub.ptys[2], timeout=20) as line:

        def ask(command: bytes) -> bytes:
            line.write(command + b"\r")
            answer: bytes = (
                line.read_until(b"\r") if command != b"bad" else line.read(1)
            )
            return answer

        assert ask(b"C") == b"\r"
        assert ask(b"S8") == b"\r"
        assert ask(b"V") == b"V1013\r"
        assert ask(b"F") == b"F00\r"
        assert ask(b"bad") == b"\a"
        line.write(b"t1230\r")
        assert line.read(1) == b"\a"
        assert ask(b"O") == b"\r"
        assert ask(b"t1230") == b"z\r"
        assert ask(b"C") == b"\r"
    assert "refused, no frame: bad" in hub.error_line()


@pytest.mark.sampled(1)
def test_links_of_two_processes(hub: HubProcess) -> None:
    script = f"""
import sys
from rtgen.runtime import RealClock
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.bus.links import open_link
sys.path.insert(0, {sys.path[0]!r})
from stations import Recorder
link = open_link(RealClock(), "socketcand", "two", 0, {hub.options()!r})
echo = Recorder(0x601, answer=lambda frame: [Frame(0x581, frame.data[::-1])])
link.attach(echo)
link.send([Frame(0x701, b"\\0")], echo)
assert link.wait(lambda: len(echo.frames) == 100, 60 * 10**9)
link.detach(echo)
"""
    link = hub.link("two")
    station = Recorder(0x581, 0x701)
    link.attach(station)
    script = script.replace(repr(sys.path[0]), repr(str(__file__).rpartition("/")[0]))
    with subprocess.Popen([sys.executable, "-c", script]) as process:
        until(link, lambda: station.ids == [0x701])
        for n in range(100):
            link.send([Frame(0x601, bytes([n, 0]))], station)
        until(link, lambda: len(station.frames) == 101)
        assert process.wait(30) == 0
    assert [f.data for f in station.frames[1:]] == [bytes([0, n]) for n in range(100)]
    link.detach(station)


def test_stations_of_one_process_and_the_hub(hub: HubProcess) -> None:
    link = hub.link("local")
    a, b = Recorder(), Recorder()
    link.attach(a)
    link.attach(b)
    with hub.raw("local") as end:
        link.send([Frame(0x10)], a)
        assert frames_of(end, 1) == [("010 ", " ")]
        end.sendall(b"< send 11 0 >")
        until(link, lambda: a.ids == [0x11] and len(b.ids) == 2)
        assert b.ids == [0x10, 0x11]
    link.detach(a)
    link.detach(b)


def test_a_hub_that_ends_and_comes_back() -> None:
    with HubProcess() as hub:
        link = hub.link()
        station = Recorder(3)
        link.attach(station)
        outcomes: list[object] = []
        link.sdo(5).submit_upload(0x1000, 0, outcomes.append)
        hub.end(signal.SIGKILL)
        until(link, lambda: station.changes == [False])
    assert not link.up
    assert isinstance(outcomes[0], LinkError)
    with pytest.raises(LinkError, match=r"socketcand can0 at .* is off"):
        link.send([Frame(1)], station)
    with HubProcess(port=hub.port) as again:
        until(link, lambda: station.changes == [False, True])
        with again.raw() as end:
            link.send([Frame(2)], station)
            assert frames_of(end, 1) == [("002 ", " ")]
            end.sendall(b"< send 3 0 >")
            until(link, lambda: station.ids == [3])
        link.detach(station)


def test_a_link_over_slcan_and_the_end_of_its_line() -> None:
    with HubProcess("--slcan-pty") as hub:
        link = hub.link()
        line = open_link(RealClock(), "slcan", hub.ptys[0], 0, "sleep_after_open=0")
        a, b = Recorder(), Recorder(answer=lambda frame: [Frame(2, frame.data)])
        link.attach(a)
        line.attach(b)
        # Data that arrive before the hub knows that the line is open are not forwarded.
        line.send([Frame(3)], b)
        until(link, lambda: a.frames == [Frame(3)])
        link.send([Frame(1, b"12345678")], a)
        until(link, lambda: a.frames == [Frame(3), Frame(2, b"12345678")])
        assert b.frames == [Frame(1, b"12345678")]
        hub.end(signal.SIGKILL)
        until(line, lambda: b.changes == [False])
        until(link, lambda: a.changes == [False])
    line.detach(b)
    link.detach(a)


def test_a_hub_that_stands_still_stops_nobody() -> None:
    with HubProcess() as hub:
        link = hub.link()
        station = Recorder()
        link.attach(station)
        assert isinstance(link, RealLink)
        hub.tell(signal.SIGSTOP)
        for _ in range(5000):
            link.send([Frame(1, bytes(8))] * 100, station)
            if link.lost:
                break
        assert link.lost
        station.deadline = link.now()
        link.refresh(station)
        until(link, lambda: bool(station.polls))
        link.detach(station)
        assert link.closed
        hub.tell(signal.SIGCONT)


def test_bus_off_and_other_faults() -> None:
    """The bus is off for some seconds after the start: longer, if this machine is slow."""
    assert any(_frames_before_bus_off(seconds) for seconds in (3, 30, 90))


def _frames_before_bus_off(seconds: int) -> bool:
    """Return whether the first frames came before bus-off; then check the recovered bus."""
    faults = (f"bus-off={seconds}:0.3", "loss=1@111", "delay=500@222")
    a, b = Recorder(), Recorder()
    with (
        HubProcess(*(word for fault in faults for word in ("--fault", fault))) as hub,
        ExitStack() as ends,
    ):
        link, other = hub.link(), hub.link(more=",tcp_tune=False")
        for end, recorder in ((link, a), (other, b)):
            end.attach(recorder)
            ends.callback(end.detach, recorder)
        link.send([Frame(0x111), Frame(0x222), Frame(0x333)], a)
        until(other, lambda: len(b.frames) == 2 or b.changes != [])
        if len(b.frames) < 2:
            return False
        assert b.ids == [0x333, 0x222]
        limit = (seconds + 5) * SECOND
        if not link.wait(lambda: a.changes == [False, True], limit):
            return False
        until(other, lambda: b.changes == [False, True])
        link.send([Frame(0x444)], a)
        until(other, lambda: len(b.frames) == 3)
        ends.close()
        output = hub.end()
    assert "bus-off" in output
    assert "the buses are back" in output
    assert "can0: 4 carried, 1 lost by faults, 0 refused" in output
    return True


def test_a_loss_is_the_same_for_the_same_seed() -> None:
    def run_once() -> Iterable[str]:
        options = ("--fault", "loss=0.5", "--seed", "7")
        with HubProcess(*options) as hub, hub.raw() as a, hub.raw() as b:
            a.sendall(b"".join(b"< send %03x 0 >" % n for n in range(40)))
            a.sendall(b"< send 7ff 0 >" * 40)
            text = ""
            while text.count("7FF") < 5:
                data = b.recv(65536)
                assert data, "the hub has closed the connection"
                text += data.decode()
        return re.findall("frame (0..)", text)

    first = run_once()
    assert 5 < len(list(first)) < 35
    assert first == run_once()


@pytest.mark.sampled(1)
def test_the_end(hub: HubProcess) -> None:
    for how in (signal.SIGINT, signal.SIGTERM):
        with HubProcess() as hub, hub.raw() as end:
            end.sendall(b"< send 1 0 >")
            end.sendall(b"< echo >")
            assert end.recv(256) == b"< echo >"
            output = hub.end(how)
            assert hub.code == 0
            assert output == "can0: 1 carried, 0 lost by faults, 0 refused\n"
            assert end.recv(1) == b""


def test_too_many_clients(monkeypatch: pytest.MonkeyPatch) -> None:
    from rtgen.runtime.canopen.bus import hub as module

    monkeypatch.setattr(module, "MAX_CLIENTS", 1)
    messages: list[str] = []

    async def work() -> None:
        hub = module.Hub(HubSettings(), messages.append)
        host, port = await hub.listen("localhost", 0)
        reader, writer = await asyncio.open_connection(host, port)
        assert await reader.read(256) == b"< hi >"
        other, second = await asyncio.open_connection(host, port)
        assert await other.read(256) == b""
        for one in (writer, second):
            one.close()
        await hub.close()

    asyncio.run(work())
    assert len(messages) == 1
    assert "cut off, there are 1 clients already" in messages[0]


def test_what_cannot_be_served(capfd: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert run(["can", "hub", "--port", port]) == 3
    taken_text = f"cannot listen at 127.0.0.1:{port}: Address already in use\n"
    assert taken_text in capfd.readouterr().err
    assert run(["can", "hub", "--port", "0", "--fault", "fire=1"]) == 2
    assert "'fire=1' is not a fault" in capfd.readouterr().err
    assert run(["can", "hub", "--port", "0", "--fault", "loss=1@20000000"]) == 2
    assert "an identifier is at most 1FFFFFFF" in capfd.readouterr().err
    words = ["can", "hub", "--port", "0", "--slcan-pty", "--slcan-channel", "no name"]
    assert run(words) == 3
    assert "'no name' is not a name of a channel" in capfd.readouterr().err


def send_until_full_then_receive(bus: OpenBus, hub_end: socket.socket) -> None:
    while bus.send(Frame(1, bytes(8))):
        continue
    # No part of the last frame was sent. Now the hub ends within a text.
    hub_end.sendall(b"< frame 123 1.0")
    hub_end.shutdown(socket.SHUT_WR)
    while True:
        bus.receive_events(0.1, 1)


def test_a_client_of_a_hub_that_does_not_read_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(socketcand_bus, "_TIMEOUT", 0.05)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            end, _ = server.accept()
            ends.append(end)
            end.sendall(b"< hi >")
            for _ in range(2):
                end.recv(100)
                end.sendall(b"< ok >")

        ends: list[socket.socket] = []
        thread = threading.Thread(target=answer)
        thread.start()
        options = f"host=127.0.0.1,port={server.getsockname()[1]}"
        bus = open_bus(bus_address("socketcand", "can0", 0, options))
        thread.join()
        with ends[0], pytest.raises(LinkError, match=r"not read a frame|has closed"):
            send_until_full_then_receive(bus, ends[0])
        bus.close()


def test_channels_that_nobody_uses_are_forgotten() -> None:
    async def use() -> None:
        hub = Hub(HubSettings(), lambda text: None)
        used = hub.bus("used")
        assert used is not None
        used.join(FakePort("a", hub.settings))
        for number in range(500):
            bus = hub.bus(f"name{number}")
            assert bus is not None
            sender = FakePort("b", hub.settings)
            bus.join(sender)
            bus.put(sender, Frame(1, b""))
            await asyncio.sleep(0)
            bus.leave(sender)
        assert len(hub.buses) == MAX_CHANNELS
        assert hub.bus("used") is used
        assert hub.bus("name499") is bus
        rows = hub.report()
        assert rows[-1].startswith("437 unused channels: 437 carried, 0 lost")
        assert len(rows) == MAX_CHANNELS + 1

    asyncio.run(use())


def test_channels_in_use_are_bounded() -> None:
    async def use() -> None:
        hub = Hub(HubSettings(), lambda text: None)
        for number in range(MAX_CHANNELS):
            bus = hub.bus(f"name{number}")
            assert bus is not None
            bus.join(FakePort("a", hub.settings))
        assert hub.bus("one_more") is None

    asyncio.run(use())


def test_a_client_that_has_only_opened_a_channel_uses_it(hub: HubProcess) -> None:
    with ExitStack() as ends:

        def opened(channel: str) -> socket.socket:
            end = ends.enter_context(socket.create_connection((hub.host, hub.port)))
            assert end.recv(100) == b"< hi >"
            end.sendall(f"< open {channel} >".encode())
            assert end.recv(100) == b"< ok >"
            return end

        first = opened("first")
        for number in range(2 * MAX_CHANNELS):
            opened(f"short{number}").close()
        for end, channel in ((first, "first"), (opened("first"), "first")):
            end.sendall(b"< rawmode >")
            assert end.recv(100) == b"< ok >", channel
        with socketcand(hub, "first") as bus:
            bus.send(message(0x123, b"\1"))
            [(identifier, _)] = frames_of(first, 1)
            assert identifier.strip() == "123"
