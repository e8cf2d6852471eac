"""Ports as topics, with readers and writers of cyclonedds and Zenoh that use only ROS's names.

Names, types and hashes of the other side are written by hand as ROS 2 has them.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from types import ModuleType
from typing import Any

import media
import pytest
from free_ports import free_port
from patience import PATIENCE, until

from rtgen.facts.ros_qos import PROFILES, History, Profile
from rtgen.facts.ros_zenoh import parse_attachment
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.ros2.network import Ros2Error, RosNode, RosTopic
from rtgen.runtime.ros2.ports import Joint, RosPorts

cyclonedds = pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

FLOAT32 = "RIHS01_7170d3d8f841f7be3172ce5f4f59f3a4d7f63b0447e8b33327601ad64d83d6e2"
DOMAIN = media.own_domain()
WAIT = 20.0


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def dds_class() -> Any:
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import float32

    name = "std_msgs::msg::dds_::Float32_"
    return make_idl_struct("Float32_", name, {"data": float32})


def participant() -> Any:
    from cyclonedds.domain import DomainParticipant

    return DomainParticipant(DOMAIN)


def reliable(identity: str = "") -> Any:
    """Return a QoS; `identity` is `clientid` or `serviceid` of an end of a service."""
    from cyclonedds.qos import Policy, Qos

    return Qos(
        Policy.Reliability.Reliable(1_000_000_000),
        Policy.DataRepresentation(True, False),
        *((Policy.Userdata(f"{identity}=1.2.3;".encode()),) if identity else ()),
    )


def ports(
    network: Any, messages: dict[str, ModuleType], profile: Profile
) -> tuple[RosPorts, OutPort[Any], InPort[Any]]:
    type_ = messages["std_msgs"].Float32
    out: OutPort[Any] = OutPort("out", type_, "node0")
    in_: InPort[Any] = InPort("in", type_, "node0")
    joints = [Joint(out, "/robot/speed", profile), Joint(in_, "/robot/goal", profile)]
    return RosPorts(network, joints), out, in_


def dds_network() -> Any:
    from rtgen.runtime.ros2.dds import open_dds

    return open_dds(RosNode("node", "/robot", DOMAIN))


def test_dds(messages: dict[str, ModuleType], stack: ExitStack) -> None:
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    made, out, in_ = ports(dds_network(), messages, PROFILES["default"])
    stack.callback(made.close)
    type_ = dds_class()
    part = participant()
    reader = DataReader(part, Topic(part, "rt/robot/speed", type_), reliable())
    writer = DataWriter(part, Topic(part, "rt/robot/goal", type_), reliable())
    until(reader.get_matched_publications)
    until(writer.get_matched_subscriptions)
    out.write(messages["std_msgs"].Float32(2.5))
    assert until(lambda: reader.take(8))[0].data == 2.5
    writer.write(type_(data=-4.0))
    until(in_.is_new)
    assert in_.read() == messages["std_msgs"].Float32(-4.0)


def test_dds_shows_the_hash_and_the_node(
    messages: dict[str, ModuleType], stack: ExitStack
) -> None:
    """In USER_DATA, and on `ros_discovery_info`, whose reader uses rtgen's messages."""
    from cyclonedds.builtin import (
        BuiltinDataReader,
        BuiltinTopicDcpsParticipant,
        BuiltinTopicDcpsPublication,
    )
    from cyclonedds.qos import Policy

    from rtgen.runtime.ros2.graph import ParticipantEntitiesInfo
    from rtgen.runtime.xcdr import deserialize

    network = dds_network()
    made, _, _ = ports(network, messages, PROFILES["default"])
    stack.callback(made.close)
    other = dds_network()
    stack.callback(other.close)
    graph: list[bytes] = []
    topic = RosTopic("/x", ParticipantEntitiesInfo)
    # The graph's topic has no prefix.
    from rtgen.facts import ros_names

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ros_names, "dds_topic", lambda _: "ros_discovery_info")
        # Nodes share one instance: the last message alone would be that of one node.
        every = PROFILES["map"]._replace(history=History.KEEP_ALL)
        other.subscribe(topic, every, graph.append)
    part = participant()
    publications = BuiltinDataReader(part, BuiltinTopicDcpsPublication)

    def speed() -> Any:
        found = [p for p in publications.take(64) if p.topic_name == "rt/robot/speed"]
        return found[0] if found else None

    found = until(speed)
    assert found.type_name == "std_msgs::msg::dds_::Float32_"
    assert bytes(found.qos[Policy.Userdata].data) == f"typehash={FLOAT32};".encode()
    participants = BuiltinDataReader(part, BuiltinTopicDcpsParticipant)
    data = [p.qos[Policy.Userdata] for p in participants.take(64)]
    assert b"enclave=/;" in [bytes(each.data) for each in data if each is not None]

    def node() -> Any:
        infos = [deserialize(ParticipantEntitiesInfo, octets) for octets in graph]
        return [
            node
            for info in infos
            for node in info.node_entities_info_seq
            if node.reader_gid_seq and node.writer_gid_seq
        ]

    shown = until(node)[0]
    assert (shown.node_namespace, shown.node_name) == ("/robot", "node")
    assert bytes(shown.writer_gid_seq[0].data) == found.key.bytes


SUCCESSORS = """
import gc
from rtgen.runtime.ros2.dds import open_dds
from rtgen.runtime.ros2.network import RosNode

last = open_dds(RosNode("node", "/", {domain}))
for _ in range(30):
    following = open_dds(RosNode("node", "/", {domain}))
    last.close()
    last = following
    gc.collect()
last.close()
"""


@pytest.mark.sampled(0)
def test_types_of_dds_outlive_the_network_that_brought_them() -> None:
    """Cyclone DDS would look at memory that is free, and end the process."""
    script = SUCCESSORS.format(domain=DOMAIN)
    subprocess.run([sys.executable, "-c", script], check=True, timeout=PATIENCE)


def zenoh_pair(stack: ExitStack) -> tuple[Any, Any, str]:
    """Return a network of rtgen, a plain session of Zenoh connected with it, and its locator."""
    from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

    place = f"tcp/127.0.0.1:{free_port()}"
    plain = zenoh.open(configuration(connect=None, listen=place))
    stack.callback(plain.close)
    config = configuration(connect=place)
    network = open_zenoh(RosNode("node", "/robot", DOMAIN), config=config)
    return network, plain, place


def test_a_session_of_zenoh_that_finds_nobody_is_reported(
    stack: ExitStack,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    from rtgen.runtime.ros2 import zenoh as networks

    found, _, _ = zenoh_pair(stack)
    stack.callback(found.close)
    until(found.medium._session.info.peers_zid)
    found.medium._tell_if_alone()
    assert not caplog.messages
    monkeypatch.setattr(networks, "_REPORT_AFTER", 0.05)
    config = networks.configuration(connect=f"tcp/127.0.0.1:{free_port()}")
    alone = networks.open_zenoh(RosNode("node", "/", DOMAIN), config=config)
    stack.callback(alone.close)
    alone.medium._looking.join()
    assert "no router or peer of Zenoh was found" in caplog.messages[0]


SPEED = f"{DOMAIN}/robot/speed/std_msgs::msg::dds_::Float32_/{FLOAT32}"
GOAL = f"{DOMAIN}/robot/goal/std_msgs::msg::dds_::Float32_/{FLOAT32}"


def test_zenoh(messages: dict[str, ModuleType], stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    made, out, in_ = ports(network, messages, PROFILES["default"])
    stack.callback(made.close)
    came: list[Any] = []
    stack.callback(plain.declare_subscriber(SPEED, came.append).undeclare)

    def written() -> bool:
        out.write(messages["std_msgs"].Float32(2.5))
        return bool(came)

    until(written)
    sample = came[0]
    assert sample.payload.to_bytes() == b"\x00\x01\x00\x00\x00\x00\x20\x40"
    attachment = parse_attachment(sample.attachment.to_bytes())
    assert attachment.sequence >= 1
    publisher = plain.declare_publisher(GOAL)

    def arrived() -> bool:
        publisher.put(b"\x00\x01\x00\x00\x00\x00\x80\xc0")
        return in_.is_new()

    until(arrived)
    assert in_.read() == messages["std_msgs"].Float32(-4.0)


def test_zenoh_shows_its_tokens(
    messages: dict[str, ModuleType], stack: ExitStack
) -> None:
    network, plain, _ = zenoh_pair(stack)
    made, _, _ = ports(network, messages, PROFILES["sensor_data"])
    stack.callback(made.close)
    zid = str(network.medium._session.zid())
    entity = f"std_msgs::msg::dds_::Float32_/{FLOAT32}/2::,5:,:,:,,"
    expected = {
        f"@ros2_lv/{DOMAIN}/{zid}/0/0/NN/%/%robot/node",
        f"@ros2_lv/{DOMAIN}/{zid}/0/1/MP/%/%robot/node/%robot%speed/{entity}",
        f"@ros2_lv/{DOMAIN}/{zid}/0/2/MS/%/%robot/node/%robot%goal/{entity}",
    }

    def tokens() -> set[str]:
        replies = plain.liveliness().get(f"@ros2_lv/{DOMAIN}/**")
        return {str(reply.ok.key_expr) for reply in replies if reply.ok is not None}

    assert until(lambda: tokens() if len(tokens()) == 3 else None) == expected


def test_other_types_are_refused(messages: dict[str, ModuleType]) -> None:
    from rtgen.runtime import idl
    from rtgen.runtime.cdr import Aggregated

    class Own(Aggregated):
        _descriptor_ = idl.struct("lab::Own", x=idl.DOUBLE)

    out: OutPort[Any] = OutPort("out", Own, "node0")
    with pytest.raises(Ros2Error, match="lab::Own is not a message of ROS 2"):
        RosPorts(dds_network(), [Joint(out, "/own", PROFILES["default"])])


def test_garbage_is_counted(messages: dict[str, ModuleType], stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    made, _, in_ = ports(network, messages, PROFILES["default"])
    stack.callback(made.close)
    publisher = plain.declare_publisher(GOAL)
    reader = made._ends[1]

    def refused() -> bool:
        publisher.put(b"\x00\x01\x00\x00\x01")
        return reader.invalid > 0

    until(refused)
    assert not in_.is_new()


def test_a_reader_that_takes_nothing_does_not_stop_the_writer(
    stack: ExitStack,
) -> None:
    """It is reliable, so that cyclonedds has no room after some messages: that is an error."""
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    from rtgen.tools.running.ros2_classes import message_classes

    network = dds_network()
    stack.callback(network.close)
    name = "std_msgs/msg/String"
    topic = RosTopic("/robot/slow", message_classes(name)[name])
    publish = network.publisher(topic, PROFILES["default"])
    part = participant()
    class_ = make_idl_struct("String_", "std_msgs::msg::dds_::String_", {"data": str})
    full = Qos(
        Policy.History.KeepAll, Policy.ResourceLimits(1, -1, -1), base=reliable()
    )
    reader = DataReader(part, Topic(part, "rt/robot/slow", class_), full)
    until(reader.get_matched_publications)
    octets = b"\x00\x01\x00\x00" + topic.type("x" * 200_000).to_cdr(True)

    def fill() -> None:
        for _ in range(100):
            publish(octets)

    with pytest.raises(Ros2Error, match="no room for a sample"):
        fill()


def test_cyclone_keeps_more_than_the_depth_of_types_that_cannot_be_large() -> None:
    """Its own history drops without a count."""
    from rtgen.runtime.ros2.dds_topics import room
    from rtgen.tools.running.ros2 import message_classes

    kept = {
        "std_msgs/msg/Float32": 8192,
        "geometry_msgs/msg/TwistWithCovariance": 8192,
        "std_msgs/msg/String": 1024,
        "geometry_msgs/msg/PoseStamped": 1024,
        "sensor_msgs/msg/Image": 128,
        "nav_msgs/msg/Path": 128,
    }
    classes = message_classes(*kept)
    assert {name: room(Profile(), classes[name]) for name in kept} == kept
    assert room(Profile(10_000), classes["sensor_msgs/msg/Image"]) == 10_000
