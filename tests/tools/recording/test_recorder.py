"""The content of a recording, as MCAP's own library and rtgen read it."""

from __future__ import annotations

import io
import json
import random
import tracemalloc
from pathlib import Path
from typing import Any, ClassVar

import pytest
from mcap.reader import make_reader
from recorded_runs import MS, Adder, Counter, counting, record

from refrobots.iis import TimedPose2D
from refrobots.rtc import TimedLong
from rtgen.facts import opaque_rpc as facts
from rtgen.runtime import (
    Component,
    JsonLinesRecorder,
    OutPort,
    RealClock,
    SimulatedClock,
    System,
)
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.runtime.opaque_rpc import ChannelError, Handlers, SimulatedServer
from rtgen.runtime.opaque_rpc.communication import OpaqueRpcCommunication
from rtgen.runtime.opaque_rpc.interface import OpaqueRpc
from rtgen.runtime.opaque_rpc.proxy import CommunicationChannel
from rtgen.runtime.values import AnyValue
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.recording.channels import cdr_encoder
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.mcap_writer import COMPRESSIONS, McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.recording.schema_types import type_of
from rtgen.tools.recording.schemas import Schema


def events(path: Path, *kinds: str) -> list[dict[str, Any]]:
    return [*Log(path).events(lambda head: head["event"] in kinds)]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_every_message_is_what_the_log_holds(tmp_path: Path, compression: str) -> None:
    lines = io.StringIO()
    path = tmp_path / "a.mcap"
    with McapWriter(path, compression) as writer, counting() as system:
        system.add_listener(JsonLinesRecorder(lines))
        Recorder(system, writer)
        system.run(100 * MS)
    logged = [json.loads(line) for line in lines.getvalue().splitlines()]
    assert events(path, "state", "sample") == logged
    assert len(logged) > 150


def test_mcap_s_own_reader_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    record(path)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        found = [*reader.iter_messages(topics=["/Counter0/count"])]
    assert [type(summary.statistics.chunk_count), len(found)] == [int, 100]
    for number, (schema, channel, message) in enumerate(found, 1):
        assert schema is not None
        assert (schema.name, schema.encoding) == ("RTC::TimedLong", "omgidl")
        assert channel.message_encoding == "cdr"
        assert message.data[:4] == b"\0\1\0\0"
        assert deserialize(TimedLong, message.data).data == number
        assert message.log_time == message.publish_time == (number - 1) * MS
        assert message.sequence == number - 1


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        record(tmp_path / name)
    first = (tmp_path / "a").read_bytes()
    assert first == (tmp_path / "b").read_bytes()
    assert str(tmp_path).encode() not in first


def test_components_parameters_and_connections(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path, "none") as writer, counting() as system:
        Recorder(system, writer)
        system.at(10 * MS, lambda: system.disconnect("counts"))
        system.run(20 * MS)
    components = events(path, "component")
    assert [(c["instance"], c["type"], c["rate"]) for c in components] == [
        ("Adder0", "Adder", 300.0),
        ("Counter0", "Counter", 1000.0),
    ]
    made, cut = events(path, "connection")
    assert (made["t"], made["source"], made["target"], made["connected"]) == (
        0,
        "Counter0.count",
        "Adder0.in",
        True,
    )
    assert {"name": "dataport.buffer.length", "value": "64"} in made["properties"]
    assert (cut["t"], cut["name"], cut["connected"]) == (10 * MS, "counts", False)


def test_frames_of_a_bus(tmp_path: Path) -> None:
    class Nobody:
        identifiers = None
        deadline = None

        def receive(self, frame: Frame, now: int) -> tuple[Frame, ...]:
            return ()

        def poll(self, now: int) -> tuple[Frame, ...]:
            return ()

        def link_changed(self, up: bool, now: int) -> tuple[Frame, ...]:
            return ()

    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer, counting() as system:
        Recorder(system, writer)
        link = open_link(system.clock, channel="can7")
        link.attach(Nobody())
        frames = [Frame(0x181, b"\1\2"), Frame(0x1234567, remote=True, extended=True)]
        system.at(5 * MS, lambda: link.send(frames))
        system.run(10 * MS)
    common = {"t": 5 * MS, "event": "frame", "bus": "can7"}
    # The lower identifier wins arbitration.
    assert events(path, "frame") == [
        common | {"id": 0x181, "extended": False, "remote": False, "data": [1, 2]},
        common | {"id": 0x1234567, "extended": True, "remote": True, "data": []},
    ]


class Board:
    """Two functions of one octet."""

    handlers: ClassVar[Handlers] = {
        b"\x67\x2a\0\1": lambda more: b"<" + more(1) + b">",
        b"\x67\x2a\0\2": lambda more: b"?" + more(1),
    }


class Caller(Component):
    """Has a channel to the board."""

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.channel = CommunicationChannel(
            self.add_consumer("rpc", facts.INSTANCE, OpaqueRpc)
        )


def test_calls_of_a_board(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    caller = Caller("Caller0")
    channel = caller.channel
    with McapWriter(path) as writer, System(SimulatedClock()) as system:
        system.add(OpaqueRpcCommunication("Communication0"), 1000.0)
        system.add(caller, 1000.0)
        system.connect(("Caller0", "rpc"), ("Communication0", facts.PORT))
        system.configure("Communication0", "port", "8931")
        system.activate("Communication0")
        network = system.clock.network
        assert network is not None
        server = SimulatedServer(network, "127.0.0.1:8931", Board(), 64)
        Recorder(system, writer)
        system.run(2 * MS)
        assert channel.begin(b"\x67\x2a\0\1x", 2) + channel.more(1) == b"<x>"
        channel.end()
        channel.begin(b"\x67\x2a\0\2y", 2)
        channel.reset()
        server.close()
        with pytest.raises(ChannelError) as caught:
            channel.begin(b"\x67\x2a\0\1z", 2)
    calls = events(path, "call")
    assert {(c["instance"], c["t"]) for c in calls} == {("Communication0", 2 * MS)}
    assert [(bytes(c["request"]), bytes(c["reply"]), c["error"]) for c in calls] == [
        (b"\x67\x2a\0\1x", b"<x>", ""),
        (b"\x67\x2a\0\2y", b"?y", "given up by the caller"),
        (b"\x67\x2a\0\1z", b"", caught.value.reason),
    ]


def test_parameters_that_change(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer, System() as system:
        system.add(OpaqueRpcCommunication("Communication0"), 100.0)
        system.activate("Communication0")
        Recorder(system, writer)
        system.at(
            30 * MS, lambda: system.configure("Communication0", "timeout", "0.25")
        )
        system.run(60 * MS)
    changes = [e for e in events(path, "parameter") if e["parameter"] == "timeout"]
    assert [(c["t"], c["value"]) for c in changes][1:] == [(30 * MS, "0.25")]


def test_real_time_gives_utc(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path, longest=10 * MS) as writer, System(RealClock()) as system:
        system.add(Counter("Counter0"), 500.0)
        system.activate("Counter0")
        began = system.clock.now()
        Recorder(system, writer)
        system.run(100 * MS)
    ended = system.clock.now()  # components tick until the system is closed
    log = Log(path)
    assert began - 1000 * MS < log.start <= began
    samples = [e for e in log.events() if e["event"] == "sample"]
    values = [e["value"]["data"] for e in samples if e["port"] == "count"]
    assert values == [*range(1, len(values) + 1)]
    assert 0 <= samples[0]["t"] <= samples[-1]["t"] <= ended - log.start


def test_a_sample_that_violates_its_type_is_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer, counting(check="never") as system:
        recorder = Recorder(system, writer)
        counter: Any = system.component("Counter0")
        system.at(5 * MS, lambda: counter.pose.write(TimedPose2D(id=[1 << 40])))
        system.run(10 * MS)
    [message] = recorder.missing.messages()
    assert message.startswith("1 samples of Counter0.pose are missing: TimedPose2D.id")
    written = [e for e in events(path, "sample") if e["port"] == "pose"]
    assert len(written) == 3


def test_types_that_xcdr_has_no_form_for_are_json(tmp_path: Path) -> None:
    with_any = type_of(Schema("A", "struct A { any x; };"))
    assert cdr_encoder(with_any) is None
    path = tmp_path / "a.mcap"
    with McapWriter(path) as writer, counting() as system:
        adder: Any = system.component("Adder0")
        port: OutPort[Any] = adder.add_out_port("any", with_any)
        Recorder(system, writer)
        value: Any = with_any
        port.write(value(AnyValue()))
        system.run(1 * MS)
    [sample] = [e for e in events(path, "sample") if e["port"] == "any"]
    assert sample["value"] == {"x": None}


def test_mutable_types_keep_their_header(tmp_path: Path) -> None:
    mutable: Any = type_of(Schema("A", "@mutable struct A { @id(7) long x; };"))
    encode = cdr_encoder(mutable)
    assert encode is not None
    octets = encode(mutable(5))
    assert octets[:4] == b"\0\3\0\0"
    assert deserialize(mutable, octets) == mutable(5)


def test_a_file_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match="cannot write"):
        McapWriter(tmp_path / "file" / "a.mcap")


def test_two_components_that_tick_at_one_instant_keep_their_order(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.mcap"
    record(path, 10)
    order = [(e["t"], e["instance"]) for e in events(path, "sample")]
    assert order[:2] == [(0, "Adder0"), (0, "Counter0")]
    assert isinstance(Adder("a"), Adder)


def test_without_mcap_the_message_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "rtgen.tools.recording.mcap_writer.find_spec", lambda name: None
    )
    with pytest.raises(RecordingError, match="mcap, which is not installed") as caught:
        McapWriter(tmp_path / "a.mcap")
    assert caught.value.hint == "pip install ./runtime '.[record]' in a clone of rtgen"
    assert not (tmp_path / "a.mcap").exists()


def test_memory_does_not_grow_with_the_file(tmp_path: Path) -> None:
    data = random.Random(1).randbytes(1 << 13)
    path = tmp_path / "a.mcap"
    with McapWriter(path, "none") as writer:
        channel = writer.channel("/x", "json", 0, {})
        tracemalloc.start()
        try:
            for number in range(4096):
                writer.message(channel, number, data)
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert path.stat().st_size > 4096 << 13
    assert peak < 2 << 20
