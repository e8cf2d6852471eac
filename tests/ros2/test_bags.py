"""Bags of ROS 2 that runs write, as rosbags and mcap-ros2-support read them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from typing import Any

import media
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from patience import until
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime import RealClock, System
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.ros2.network import RosNode
from rtgen.runtime.ros2.ports import Joint, RosPorts
from rtgen.tools.recording.bag_recorder import BagRecorder, is_hidden
from rtgen.tools.recording.bag_writer import BagWriter
from rtgen.tools.recording.errors import RecordingError

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

DOMAIN = media.own_domain()
STORE = get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def network() -> Any:
    from rtgen.runtime.ros2.dds import open_dds

    return open_dds(RosNode("node", "/robot", DOMAIN))


def recorded(stack: ExitStack, path: Path) -> tuple[Any, BagRecorder]:
    """Return a network whose messages are recorded until the stack is closed."""
    writer = stack.enter_context(BagWriter(path))
    recorder = BagRecorder(stack.enter_context(System(RealClock())), writer)
    stack.callback(recorder.close)
    made = network()
    made.observe(recorder.observe)
    recorder.begin()
    return made, recorder


@pytest.mark.waits
def test_both_directions_are_recorded(
    messages: dict[str, ModuleType], tmp_path: Path
) -> None:
    """Sent and received messages; what the process sends to itself is there once."""
    float32 = messages["std_msgs"].Float32
    odometry = messages["nav_msgs"].Odometry
    bag = tmp_path / "bags" / "run"
    with ExitStack() as stack:
        made, _ = recorded(stack, bag)
        out: OutPort[Any] = OutPort("out", float32, "node0")
        in_: InPort[Any] = InPort("in", odometry, "node0")
        own_out: OutPort[Any] = OutPort("own", float32, "node0")
        own_in: InPort[Any] = InPort("own", float32, "node0")
        twice: InPort[Any] = InPort("twice", float32, "node0")
        unused: OutPort[Any] = OutPort("unused", float32, "node0")
        ports = (
            Joint(out, "/robot/speed", PROFILES["sensor_data"]),
            Joint(in_, "/robot/odom", PROFILES["default"]),
            Joint(own_out, "/robot/own", PROFILES["default"]),
            Joint(own_in, "/robot/own", PROFILES["default"]),
            Joint(twice, "/robot/own", PROFILES["default"]),
            Joint(unused, "/robot/unused", PROFILES["map"]),
        )
        stack.callback(RosPorts(made, ports).close)
        other = network()
        far: OutPort[Any] = OutPort("far", odometry, "far0")
        joint = Joint(far, "/robot/odom", PROFILES["default"])
        stack.callback(RosPorts(other, [joint]).close)
        message = odometry()
        message.pose.pose.position.x = 2.5

        def is_received() -> bool:
            far.write(message)
            return in_.is_new()

        until(is_received)
        for number in range(5):
            out.write(float32(number))
            own_out.write(float32(number))
        until(lambda: own_in.is_new() and twice.is_new())
        until(lambda: own_in.read_newest() == float32(4.0) or None)
    with Reader(bag) as reader:
        topics = {each.topic: each for each in reader.connections}
        assert {name: each.msgcount for name, each in topics.items()} == {
            "/robot/speed": 5,
            "/robot/odom": topics["/robot/odom"].msgcount,
            "/robot/own": 5,
            "/robot/unused": 0,
        }
        assert topics["/robot/odom"].msgcount > 0
        assert all(c.digest == STORE.hash_rihs01(c.msgtype) for c in topics.values())
        offered: dict[str, Any] = {name: each.ext for name, each in topics.items()}
        [sensor] = offered["/robot/speed"].offered_qos_profiles
        assert (sensor.depth, sensor.reliability) == (5, QosReliability.BEST_EFFORT)
        [kept] = offered["/robot/unused"].offered_qos_profiles
        assert kept.durability is QosDurability.TRANSIENT_LOCAL
        values: dict[str, list[Any]] = {}
        times = []
        for connection, time, raw in reader.messages():
            value: Any = STORE.deserialize_cdr(raw, connection.msgtype)
            values.setdefault(connection.topic, []).append(value)
            times.append(time)
        assert times == sorted(times)
        assert reader.start_time == times[0]
    assert [each.data for each in values["/robot/speed"]] == [0, 1, 2, 3, 4]
    assert [each.data for each in values["/robot/own"]] == [0, 1, 2, 3, 4]
    assert values["/robot/odom"][0].pose.pose.position.x == 2.5
    file = bag / "run_0.mcap"
    with file.open("rb") as stream:
        decoded = make_reader(stream, decoder_factories=[DecoderFactory()])
        read = [(c.topic, m) for _, c, _, m in decoded.iter_decoded_messages()]
    assert len(read) == len(times)
    assert [m.data for topic, m in read if topic == "/robot/speed"] == [0, 1, 2, 3, 4]


def test_metadata_is_that_of_jazzy(
    messages: dict[str, ModuleType], tmp_path: Path
) -> None:
    float32 = messages["std_msgs"].Float32
    with BagWriter(tmp_path / "bag") as writer:
        writer.topic("/speed", float32, [PROFILES["rosout"]])
        writer.message("/speed", 7_000, b"\0\1\0\0\0\0\0\0")
        writer.message("/speed", 9_500, b"\0\1\0\0\0\0\0\0")
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    described = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert [*described] == [
        *("version", "storage_identifier", "duration", "starting_time"),
        *("message_count", "topics_with_message_count", "compression_format"),
        *("compression_mode", "relative_file_paths", "files", "custom_data"),
        "ros_distro",
    ]
    assert (described["version"], described["ros_distro"]) == (9, "jazzy")
    assert described["starting_time"] == {"nanoseconds_since_epoch": 7_000}
    assert described["duration"] == {"nanoseconds": 2_500}
    [topic] = described["topics_with_message_count"]
    [profile] = topic["topic_metadata"]["offered_qos_profiles"]
    assert profile["lifespan"] == {"sec": 10, "nsec": 0}
    assert profile["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        [record] = [m.metadata["serialized_metadata"] for m in reader.iter_metadata()]
    without_names = {**described, "relative_file_paths": [], "files": []}
    assert yaml.safe_load(record) == without_names
    with pytest.raises(RecordingError, match="exists already"):
        BagWriter(tmp_path / "bag")


def test_a_file_alone_is_a_bag(messages: dict[str, ModuleType], tmp_path: Path) -> None:
    """`ros2 bag` takes an MCAP file without a folder, too."""
    float32 = messages["std_msgs"].Float32
    with BagWriter(tmp_path / "bag.mcap") as writer:
        writer.topic("/speed", float32, [PROFILES["default"]])
        writer.message("/speed", 1, b"\0\1\0\0\0\0\x80\x3f")
    with AnyReader([tmp_path / "bag.mcap"]) as reader:
        [(connection, time, raw)] = reader.messages()
        value: Any = reader.deserialize(raw, connection.msgtype)
        assert (time, value.data) == (1, 1.0)
    assert [path.name for path in tmp_path.iterdir()] == ["bag.mcap"]


def test_hidden_topics() -> None:
    assert is_hidden("/go/_action/feedback")
    assert not is_hidden("/go_/action")
