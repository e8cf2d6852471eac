"""All messages of an installation of ROS 2, as rclpy serializes them, with random values."""

from __future__ import annotations

import random
import time
from collections.abc import Iterator
from typing import Any

import media
import pytest
from patience import until
from random_values import Values, told
from rclpy_node import Node, node
from ros2_peers import DISTRIBUTIONS, Installation, installation
from seeds import seed

from rtgen.facts.ros_qos import PROFILES
from rtgen.ros2.rosidl import load
from rtgen.runtime.ros2.network import RosNode, RosTopic
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.tools.recording.schema_types import message_classes

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
INTERNAL = "rmw_dds_common"
"""A package whose messages have no module in Python."""


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


@pytest.fixture(scope="module")
def classes(ros2: Installation) -> dict[str, Any]:
    """Return the classes of all messages by name."""
    files = sorted(ros2.share.glob("*/msg/*.msg"))
    result = load(files, root=ros2.share)
    assert not result.diagnostics
    found = message_classes(result.model)
    names = [path.relative_to(ros2.share).with_suffix("").as_posix() for path in files]
    return {name: found[name] for name in names if not name.startswith(INTERNAL)}


@pytest.fixture(scope="module")
def peer(ros2: Installation) -> Iterator[Node]:
    with node(ros2, "peer", "/far", domain=DOMAIN) as made:
        yield made


@pytest.mark.sampled(1)
def test_every_message_as_rclpy_serializes_it(
    peer: Node, classes: dict[str, Any]
) -> None:
    """Decoded by both sides; what rclpy writes after a message is ignored."""
    values = Values(random.Random(seed()))
    with_more = 0
    for name, class_ in classes.items():
        value = values.of(class_._descriptor_)
        peer.do("decode", name, encoded(value).hex())
        there, octets = peer.event("decoded")
        assert there == told(value), name
        found = bytes.fromhex(octets)
        assert decoded(class_, found) == value, name
        assert decoded(class_, found + bytes(100_000)) == value, name
        with_more += len(found) > len(encoded(value))
    assert with_more


@pytest.mark.nightly
def test_serialized_messages_are_received(peer: Node, classes: dict[str, Any]) -> None:
    """Published as octets with more than a message behind it."""
    from rtgen.runtime.ros2.dds import open_dds

    network = open_dds(RosNode("raw", "/lab", DOMAIN))
    values = Values(random.Random(seed()))
    for name in ("test_msgs/msg/WStrings", "test_msgs/msg/MultiNested"):
        class_ = classes[name]
        sent = values.of(class_._descriptor_)
        came: list[bytes] = []
        topic = RosTopic(f"/raw/{name}", class_)
        network.subscribe(topic, PROFILES["default"], came.append)

        def received() -> list[bytes]:
            peer.do("publish", topic.name, name, [told(sent)], True)  # noqa: B023
            peer.event("published")
            time.sleep(0.1)
            return came  # noqa: B023

        until(received)
        assert len(came[0]) > len(encoded(sent))
        assert decoded(class_, came[0]) == sent
    network.close()
