"""`rtgen log export --ros2`: recordings of runs as bags of ROS 2, read by rosbags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bags import START, STEP, STORE, write
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from rtgen.cli import run as rtgen
from rtgen.compiler.project.ros2 import Ros2Settings, TopicEntry
from rtgen.facts.ros_qos import PROFILES, Reliability
from rtgen.runtime import (
    Component,
    ComponentProfile,
    SimulatedClock,
    System,
)
from rtgen.runtime.library.rtc import TimedDouble, TimedFloat, TimedString
from rtgen.tools.recording.bag_export import Exported, export
from rtgen.tools.recording.bag_files import open_recording
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.mcap_writer import McapWriter
from rtgen.tools.recording.recorder import Recorder
from rtgen.tools.running.ros2_classes import message_classes

FLOAT32 = message_classes("std_msgs/msg/Float32")["std_msgs/msg/Float32"]


class Source(Component):
    """A component with a message of ROS 2, data that can be one, and data that cannot."""

    profile = ComponentProfile("Source")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.command = self.add_out_port("command", FLOAT32)
        self.other = self.add_out_port("other", FLOAT32)
        self.speed = self.add_out_port("speed", TimedFloat)
        self.note = self.add_out_port("note", TimedString)
        self.far = self.add_out_port("far", TimedDouble)


class Sink(Component):
    """A component that reads what the first one writes."""

    profile = ComponentProfile("Sink")

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.goal = self.add_in_port("goal", FLOAT32)


def entry(port: str, topic: str, message: str | None = None) -> TopicEntry:
    instance, _, name = port.partition(".")
    return TopicEntry(
        instance=instance,
        port=name,
        topic=topic,
        profile=PROFILES["sensor_data"],
        span=None,
        message=message,
    )


SETTINGS = Ros2Settings(
    namespace="/robot",
    topics=(
        entry("Sink0.goal", "goal"),
        entry("Source0.speed", "speed", "std_msgs/msg/Float64"),
    ),
)


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    with McapWriter(path) as writer, System(SimulatedClock()) as system:
        source = Source("Source0")
        system.add(source, 100.0)
        system.add(Sink("Sink0"), 100.0)
        system.connect(("Source0", "command"), ("Sink0", "goal"), {}, "c")
        recorder = Recorder(system, writer)
        for number in range(3):
            source.command.write(FLOAT32(number))
            source.other.write(FLOAT32(-number))
            source.speed.write(TimedFloat(data=number / 2))
            source.note.write(TimedString(data="a"))
            source.far.write(TimedDouble(data=1.0))
            system.run(system.time + 10_000_000)
        recorder.end(through=True)
    return path


def exported(recording: Path, folder: Path) -> Exported:
    opened = open_recording(recording)
    assert opened is not None
    return export(opened, SETTINGS, folder)


def read(bag: Path) -> dict[str, list[tuple[int, Any]]]:
    found: dict[str, list[tuple[int, Any]]] = {}
    with Reader(bag) as reader:
        for connection, time, raw in reader.messages():
            value: Any = STORE.deserialize_cdr(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, value.data))
    return found


def test_samples_become_messages(recording: Path, tmp_path: Path) -> None:
    """By the topics of their ports, and of the ports that they reached."""
    done = exported(recording, tmp_path / "bag")
    times = [0, 10_000_000, 20_000_000]
    assert read(tmp_path / "bag") == {
        "/robot/goal": [(t, n) for n, t in enumerate(times)],
        "/Source0/other": [(t, -n) for n, t in enumerate(times)],
        "/robot/speed": [(t, n / 2) for n, t in enumerate(times)],
    }
    assert set(done.counts.values()) == {3}
    assert done.left_out == {
        "Source0.note": "RTC::TimedString",
        "Source0.far": "RTC::TimedDouble",
    }
    with Reader(tmp_path / "bag") as reader:
        topics: dict[str, Any] = {c.topic: c for c in reader.connections}
    [profile] = topics["/robot/goal"].ext.offered_qos_profiles
    assert profile.reliability.name == Reliability.BEST_EFFORT.name
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        decoded = make_reader(stream, decoder_factories=[DecoderFactory()])
        assert len([*decoded.iter_decoded_messages()]) == 9


def test_the_same_recording_gives_the_same_bytes(
    recording: Path, tmp_path: Path
) -> None:
    exported(recording, tmp_path / "one.mcap")
    exported(recording, tmp_path / "two.mcap")
    one, two = ((tmp_path / f"{n}.mcap").read_bytes() for n in ("one", "two"))
    assert one == two


def test_the_command(
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rtgen.toml").write_text('[ros2.topics]\n"Source0.other" = "/other"\n')
    assert rtgen(["log", "export", "--ros2", "run.mcap", "bag"]) == 0
    said = capfd.readouterr().err
    assert "bag: 6 messages of 2 topics" in said
    assert "left out, not messages of ROS 2: Source0.speed (RTC::TimedFloat)" in said
    assert set(read(tmp_path / "bag")) == {"/other", "/Source0/command"}
    assert rtgen(["log", "csv", "bag", "/other.data"]) == 0
    assert rtgen(["log", "export", "--ros2", "run.mcap", "bag"]) == 2
    assert "bag exists already" in capfd.readouterr().err
    assert rtgen(["log", "export", "run.mcap", "other"]) == 2
    assert rtgen(["log", "export", "--ros2", "rtgen.toml", "other"]) == 2
    assert not Path("other").exists()


@pytest.mark.parametrize("form", ["sqlite3", "mcap-file", "humble"])
def test_a_bag_becomes_a_folder_of_mcap(form: str, tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", form, range(5))
    done = exported(bag, tmp_path / "other")
    assert done.counts == {"/note": 1, "/robot/goal": 5}
    found = read(tmp_path / "other")
    assert found["/robot/goal"] == [(START + n * STEP, n) for n in range(5)]


def test_nothing_is_left_after_an_error(tmp_path: Path) -> None:
    with McapWriter(tmp_path / "a.mcap", profile="ros2") as writer:
        good = writer.schema("std_msgs/msg/Float32", "ros2msg", "float32 data\n")
        bad = writer.schema("std_msgs/msg/Float64", "ros2msg", "float64 x y\n")
        for number, schema in enumerate((good, bad)):
            channel = writer.channel(f"/t{number}", "cdr", schema, {})
            writer.message(channel, number, b"\0\1\0\0\0\0\0\0")
    with pytest.raises(RecordingError):
        exported(tmp_path / "a.mcap", tmp_path / "bag")
    assert not (tmp_path / "bag").exists()
    with McapWriter(tmp_path / "b.mcap") as writer:
        channel = writer.channel("/x", "json", 0, {})
        writer.message(channel, 1, b"{}")
    with pytest.raises(RecordingError, match="no samples that are messages"):
        exported(tmp_path / "b.mcap", tmp_path / "bag")
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize("name", ["class", "__init__", "a b"])
def test_members_that_would_be_code(name: str, tmp_path: Path) -> None:
    text = f"module RTC {{ struct TimedFloat {{ float {name}; }}; }};"
    with McapWriter(tmp_path / "a.mcap") as writer:
        schema = writer.schema("RTC::TimedFloat", "omgidl", text)
        entries = {"kind": "sample", "instance": "Source0", "port": "speed"}
        channel = writer.channel("/Source0/speed", "cdr", schema, entries)
        writer.message(channel, 1, b"\0\1\0\0\0\0\0\0")
    with pytest.raises(RecordingError):
        exported(tmp_path / "a.mcap", tmp_path / "bag")
    assert not (tmp_path / "bag").exists()
