"""Data of a proxy: samples both ways, parameters, objects by SDO."""

from __future__ import annotations

import struct
from collections.abc import Iterable

import pytest
from msgspec.structs import replace
from proxy_bench import NODE, SECOND, Bench, DriveProxy

from refrobots.rtc import Time, TimedLong
from rtgen.runtime import Component
from rtgen.runtime.canopen.description import Write
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.master.proxied_node import QUEUE
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.runtime.canopen.wire.sdo import SdoAbort


def ready(**settings: object) -> Bench:
    """Return a proxy, INACTIVE, whose node has booted."""
    bench = Bench(settings=settings)
    bench.with_node()
    bench.run(0.05)
    return bench


def active(**settings: object) -> Bench:
    bench = ready(**settings)
    bench.activate()
    return bench


def test_parameters_are_written_at_activation() -> None:
    with active(Acceleration=7) as bench:
        assert bench.node.objects.writes == [
            ((0x1017, 0), struct.pack("<H", 100)),
            ((0x6083, 0), struct.pack("<I", 7)),
        ]


class Source(Component):
    """Writes targets."""

    def __init__(self) -> None:
        super().__init__("Source0")
        self.out = self.add_out_port("out", TimedLong)


def with_source(bench: Bench) -> Source:
    source = Source()
    bench.system.add(source)
    bench.system.connect(
        ("Source0", "out"), ("Drive0", "rpdo1"), {"dataport.buffer.length": "64"}
    )
    return source


# From the device.


def test_samples_come_whole_in_order_with_their_times() -> None:
    with active() as bench:
        times = []
        for value in (1, -2, 2**31 - 1, -(2**31), 5):
            bench.run(0.003)
            times.append(bench.system.time)
            bench.node.send_position(value)
        bench.run(0.02)
        assert bench.values() == [1, -2, 2**31 - 1, -(2**31), 5]
        stamps = [s.value.tm for s in bench.samples if s.port == "tpdo1"]
        assert [t.sec * SECOND + t.nsec for t in stamps] == times


def test_none_is_lost_between_operational_and_the_first_tick() -> None:
    with ready() as bench:
        bench.node.go(NmtState.OPERATIONAL)
        for value in range(50):
            bench.node.send_position(value)
            bench.run(0.001)
        bench.until("ACTIVE")
        bench.run(0.02)
        assert bench.values() == list(range(50))


def test_the_last_samples_come_when_it_is_deactivated() -> None:
    with active() as bench:
        bench.system.deactivate("Drive0")
        for value in range(20):
            bench.node.send_position(value)
            bench.run(0.001)
        bench.until("INACTIVE")
        assert bench.values() == list(range(20))
        bench.node.send_position(99)
        bench.run(0.1)
        assert bench.values() == list(range(20))


def test_what_comes_while_inactive_is_not_kept() -> None:
    with ready() as bench:
        bench.node.send_position(1)
        bench.run(0.1)
        bench.activate()
        bench.run(0.1)
        assert bench.values() == []


def test_the_queue_is_bounded_and_counted() -> None:
    with active() as bench:
        for value in range(QUEUE + 100):
            bench.node.send_position(value)
        bench.run(0.02)
        assert bench.proxy.lost == 100
        assert bench.values() == list(range(100, QUEUE + 100))
        assert bench.system.statistics("Drive0").lost == 100


def test_pdos_too_short_are_ignored_and_of_too_long_ones_the_first_octets_taken(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with active() as bench:
        for data in (b"", b"\x01", b"\x01\0\0", b"\x02\0\0\0", b"\x03\0\0\0\xff\xff"):
            bench.node.send(Frame(0x180 + NODE, data))
        bench.run(0.02)
        assert bench.values() == [2, 3]
        assert bench.system.observable("Drive0.malformed") == (3.0, 1.0)
        reports = [r.getMessage() for r in caplog.records if "tpdo" in r.getMessage()]
        assert reports == [
            "Drive0: tpdo1 has 0 octets, not 4: it is ignored",
            "Drive0: tpdo1 has 6 octets, not 4: only 4 are used",
        ]
        assert bench.state == "ACTIVE"


def test_remote_frames_and_long_identifiers_are_no_pdos() -> None:
    with active() as bench:
        bench.node.send(
            Frame(0x180 + NODE, b"", remote=True),
            Frame(0x180 + NODE, b"\1\0\0\0", extended=True),
        )
        bench.run(0.02)
        assert bench.values() == []


# To the device.


def test_samples_become_frames_in_order() -> None:
    with active() as bench:
        source = with_source(bench)
        for value in (1, -2, 2**31 % 10**9, 4):
            source.out.write(TimedLong(Time(), value))
        bench.run(0.02)
        sent = [f.data for f in bench.recorder.frames if f.can_id == 0x200 + NODE]
        assert sent == [struct.pack("<i", v) for v in (1, -2, 2**31 % 10**9, 4)]


def test_samples_wait_until_it_is_active() -> None:
    with ready() as bench:
        with_source(bench).out.write(TimedLong(Time(), 8))
        bench.run(0.1)
        assert 0x200 + NODE not in bench.recorder.ids
        bench.activate()
        bench.run(0.02)
        assert bench.recorder.ids.count(0x200 + NODE) == 1


def test_a_value_that_its_field_cannot_have_is_an_error() -> None:
    with active() as bench:
        source = with_source(bench)
        source.out.write(TimedLong(Time(), 3))
        source.out.write(TimedLong(Time(), 10**9 + 1))
        bench.until("ERROR")
        assert bench.reason == (
            "rpdo1: Target is 1000000001, not -1000000000 to 1000000000"
        )
        bench.run(0.01)
        assert bench.commands()[-1] == (NmtCommand.STOP, NODE)


# Parameters.


def test_parameters_are_written_when_they_change() -> None:
    with active() as bench:
        bench.node.objects.writes.clear()
        bench.system.configure("Drive0", "Acceleration", "55")
        bench.run(0.05)
        assert bench.node.objects.writes == [((0x6083, 0), struct.pack("<I", 55))]
        bench.system.configure("Drive0", "boot_timeout", "1000")
        bench.run(0.05)
        assert len(bench.node.objects.writes) == 1
        assert bench.state == "ACTIVE"


def test_a_parameter_that_is_refused_while_active_is_reported() -> None:
    with active() as bench:
        bench.node.objects.aborts["write", (0x6083, 0)] = sdo.VALUE_TOO_HIGH
        bench.system.configure("Drive0", "Acceleration", "55")
        bench.run(0.05)
        assert bench.state == "ACTIVE"
        assert bench.reason == (
            "Acceleration cannot be written: 06090031h value too high"
        )
        bench.system.configure("Drive0", "Acceleration", "-1")
        bench.run(0.05)
        assert bench.reason == "Acceleration is -1, not 0 to 4294967295"


def test_a_parameter_that_is_refused_at_activation_is_an_error() -> None:
    with ready() as bench:
        bench.node.objects.aborts["write", (0x6083, 0)] = sdo.VALUE_TOO_HIGH
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == (
            "node 5: 6083h:0 cannot be written: 06090031h value too high"
        )


def test_a_parameter_that_cannot_be_is_an_error_at_activation() -> None:
    with ready(Acceleration=-1) as bench:
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == "Acceleration is -1, not 0 to 4294967295"


def test_another_node_is_taken_at_the_next_activation() -> None:
    with active() as bench:
        first = bench.node
        bench.with_node(node_id=6)
        bench.run(0.05)
        bench.system.configure("Drive0", "node_id", "6")
        bench.run(0.05)
        assert bench.state == "ACTIVE"
        bench.system.deactivate("Drive0")
        bench.until("INACTIVE")
        assert first.state is NmtState.PRE_OPERATIONAL
        bench.activate()
        assert bench.node.state is NmtState.OPERATIONAL
        assert bench.commands()[-1] == (NmtCommand.START, 6)


# Objects.


def test_objects_are_read_and_written_by_their_types() -> None:
    with active() as bench:
        proxy = bench.proxy
        assert proxy.read_object(0x1018, 1) == 0x111
        assert proxy.read_object(0x1008) == "drive"
        proxy.write_object(0x6083, 0, 123456)
        assert proxy.read_object(0x6083) == 123456
        bench.node.objects.values[0x6064, 0] = struct.pack("<i", -7)
        assert proxy.read_object(0x6064) == -7
        bench.node.objects.values[0x3000, 1] = b"\1\2\3"
        assert proxy.read_object(0x3000, 1) == b"\1\2\3"
        proxy.write_octets(0x3000, 1, b"\4")
        assert proxy.read_octets(0x3000, 1) == b"\4"
        with pytest.raises(ValueError, match="-1 is under 0"):
            proxy.write_object(0x6083, 0, -1)


def test_values_of_another_length() -> None:
    """Some servers send 4 octets for any type; fewer octets than the type has are no value."""
    with active() as bench:
        bench.node.objects.values[0x1001, 0] = b"\x11\0\0\0"
        assert bench.proxy.read_object(0x1001) == 0x11
        bench.node.objects.values[0x6064, 0] = b"\1\2"
        with pytest.raises(SdoAbort, match="06070013h length too low"):
            bench.proxy.read_object(0x6064)


def test_large_objects_go_in_blocks() -> None:
    value = bytes(range(256)) * 40
    with active() as bench:
        bench.recorder.frames.clear()
        bench.proxy.write_object(0x2000, 0, value)
        assert bench.proxy.read_object(0x2000) == value
        sent = [f.data[0] for f in bench.recorder.frames if f.can_id == 0x600 + NODE]
        assert sent[0] & ~4 == 0xC2, "a block download begins"
        assert any(byte & ~4 == 0xA0 for byte in sent), "and a block upload"


def test_a_server_without_blocks_gets_segments() -> None:
    value = bytes(range(256)) * 4
    with active() as bench:
        block_commands = []

        def refuse(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            if frame.can_id == 0x600 + NODE and frame.data[0] & 0xE1 in (0xC0, 0xA0):
                block_commands.append(frame)
                code = sdo.COMMAND_UNKNOWN.to_bytes(4, "little")
                answer = b"\x80" + frame.data[1:4] + code
                bench.link.send([Frame(0x580 + NODE, answer)])
                return []
            return [(0, frame)]

        bench.bus.disturbance = refuse
        bench.proxy.write_octets(0x2000, 0, value)
        assert bench.proxy.read_octets(0x2000, 0) == value
        assert len(block_commands) == 1, "it is asked once"


def test_without_a_bus_there_is_no_object() -> None:
    proxy = DriveProxy()
    with pytest.raises(LinkError, match="DriveProxy0 is on no bus"):
        proxy.read_object(0x1000)


@pytest.mark.parametrize("code", sdo.ABORT_TEXTS)
def test_every_abort_is_reported_by_its_code_and_in_words(code: int) -> None:
    with active() as bench:
        aborts = bench.node.objects.aborts
        aborts["read", (0x1018, 1)] = aborts["write", (0x6083, 0)] = code
        for transfer in (
            lambda: bench.proxy.read_object(0x1018, 1),
            lambda: bench.proxy.write_object(0x6083, 0, 1),
        ):
            with pytest.raises(SdoAbort, match=f"{code:08X}h {sdo.ABORT_TEXTS[code]}"):
                transfer()
        assert bench.state == "ACTIVE"
        aborts.clear()
        assert bench.proxy.read_object(0x1018, 1) == 0x111


def test_a_lost_answer_is_a_time_out() -> None:
    with active() as bench:
        lost = []

        def lose(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            if frame.can_id == 0x580 + NODE and not lost:
                lost.append(frame)
                return []
            return [(0, frame)]

        bench.bus.disturbance = lose
        with pytest.raises(SdoAbort, match="05040000h protocol timed out"):
            bench.proxy.read_object(0x1018, 1)
        bench.run(2.5)
        assert bench.proxy.read_object(0x1018, 1) == 0x111


@pytest.mark.parametrize("way", ["lost", "doubled"])
def test_a_lost_or_doubled_segment(way: str) -> None:
    """A lost segment of an answer gives a time-out, a doubled one a toggle error."""
    name = b"a rather long name of a drive"
    with active() as bench:
        bench.node.objects.values[0x1008, 0] = name
        answers = 0

        def disturb(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            nonlocal answers
            if frame.can_id == 0x580 + NODE:
                answers += 1
                if answers == 3:
                    return [] if way == "lost" else [(0, frame), (0, frame)]
            return [(0, frame)]

        bench.bus.disturbance = disturb
        expected = "05040000h" if way == "lost" else "05030000h toggle bit"
        with pytest.raises(SdoAbort, match=expected):
            bench.proxy.read_object(0x1008)
        bench.run(2.5)
        assert bench.proxy.read_object(0x1008) == name.decode()


def test_a_lost_segment_of_a_block_is_sent_again() -> None:
    value = bytes(range(250)) * 8
    with active() as bench:
        lost: list[Frame] = []

        def lose(frame: Frame, now: int) -> Iterable[tuple[int, Frame]]:
            if frame.can_id == 0x600 + NODE and frame.data[0] == 5 and not lost:
                lost.append(frame)
                return []
            return [(0, frame)]

        bench.bus.disturbance = lose
        bench.proxy.write_object(0x2000, 0, value)
        assert lost
        assert bench.node.objects.values[0x2000, 0] == value


def test_a_stopped_node_is_not_asked() -> None:
    with active() as bench:
        bench.node.go(NmtState.STOPPED)
        bench.until("ERROR")
        before = bench.system.time
        with pytest.raises(SdoAbort, match="08000022h"):
            bench.proxy.read_octets(0x1008, 0)
        with pytest.raises(SdoAbort, match="08000022h"):
            bench.proxy.write_octets(0x6083, 0, bytes(4))
        assert bench.system.time == before


def test_objects_can_be_read_in_error_if_that_is_asked_for() -> None:
    with active(sdo_in_error=1) as bench:
        bench.system.context("Drive0").fail_component(bench.proxy, "on purpose")
        bench.until("ERROR")
        bench.run(0.1)
        assert bench.node.state is NmtState.PRE_OPERATIONAL
        assert bench.commands()[-1] == (NmtCommand.ENTER_PRE_OPERATIONAL, NODE)
        assert bench.proxy.read_object(0x1008) == "drive"
        assert bench.state == "ERROR"
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.activate()


def test_a_master_without_a_network_writes_what_the_description_configures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    writes = (
        Write(0x2000, 0, b"program"),
        Write(0x6083, 0, struct.pack("<I", 100), relative=True),
    )
    described = replace(DriveProxy.description, configuration=writes)
    monkeypatch.setattr(DriveProxy, "description", described)
    with active() as bench:
        assert bench.node.objects.writes[:2] == [
            ((0x2000, 0), b"program"),
            ((0x6083, 0), struct.pack("<I", 105)),
        ]
    with ready() as bench:
        bench.node.go(NmtState.OPERATIONAL)
        bench.run(1)
        written = [number for number, _ in bench.node.objects.writes]
        assert (0x2000, 0) not in written, "it works already: nothing is changed"
