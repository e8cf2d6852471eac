"""Bags of runs beside nodes of rclpy: what they send is in it, and they read what is in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from typing import Any

import media
import pytest
from patience import until
from rclpy_node import Node, node
from ros2_peers import DISTRIBUTIONS, installation
from rosbags.rosbag2 import Reader

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime import RealClock, System
from rtgen.runtime.ports.data_ports import InPort, OutPort
from rtgen.runtime.ros2.network import RosNode
from rtgen.runtime.ros2.ports import Joint, RosPorts
from rtgen.tools.recording.bag_recorder import BagRecorder
from rtgen.tools.recording.bag_writer import BagWriter
from rtgen.tools.recording.events import Log

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
SCAN = "sensor_msgs/msg/LaserScan"


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def peer(request: pytest.FixtureRequest) -> Iterator[Node]:
    with node(installation(request.param), "peer", "/far", domain=DOMAIN) as made:
        yield made


@pytest.mark.nightly
def test_messages_of_both_sides(
    peer: Node, messages: dict[str, ModuleType], tmp_path: Path
) -> None:
    """Octets as rclpy serializes them, with those that it adds, and rtgen's own."""
    from rtgen.runtime.ros2.dds import open_dds

    scan = messages["sensor_msgs"].LaserScan
    # Text and numbers whose octets do not end at a multiple of four or eight.
    sent = {
        "header": {"frame_id": "abcde"},
        "ranges": [0.5, 1.5, 2.5],
        "angle_min": -1.0,
    }
    bag = tmp_path / "bag"
    with ExitStack() as stack:
        writer = stack.enter_context(BagWriter(bag))
        recorder = BagRecorder(stack.enter_context(System(RealClock())), writer)
        stack.callback(recorder.close)
        network = open_dds(RosNode("node", "/lab", DOMAIN))
        network.observe(recorder.observe)
        recorder.begin()
        far: InPort[Any] = InPort("far", scan, "node0")
        near: OutPort[Any] = OutPort("near", scan, "node0")
        joints = [
            Joint(far, "/far_scan", PROFILES["default"]),
            Joint(near, "/near_scan", PROFILES["default"]),
        ]
        stack.callback(RosPorts(network, joints).close)

        def is_received() -> bool:
            # The first ones may come before this side knows the publisher.
            peer.do("publish", "/far_scan", SCAN, [sent], True)
            peer.event("published")
            return far.is_new()

        until(is_received)
        value = far.read()
        near.write(value)
    with Reader(bag) as reader:
        octets = {c.topic: bytes(raw) for c, _, raw in reader.messages()}
        [hash_] = {c.digest for c in reader.connections}
    assert set(octets) == {"/far_scan", "/near_scan"}
    assert hash_.startswith("RIHS01_")
    for each in octets.values():
        peer.do("decode", SCAN, each.hex())
        decoded = peer.event("decoded")[0]
        assert decoded["header"]["frame_id"] == "abcde"
        assert decoded["ranges"] == sent["ranges"]
    values = [event["value"] for event in Log(bag).events()]
    assert len(values) > 1
    assert all(value == values[0] for value in values)
