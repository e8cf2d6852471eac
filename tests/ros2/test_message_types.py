"""All messages of an installation of ROS 2, sent to and by rclpy with random values."""

from __future__ import annotations

import math
import random
import struct
import time
from collections.abc import Iterator
from typing import Any

import media
import pytest
from patience import until
from rclpy_node import Node, node
from ros2_peers import DISTRIBUTIONS, Installation, installation
from seeds import seed

from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES
from rtgen.facts.ros_qos import PROFILES
from rtgen.ros2.rosidl import load
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.ros2.network import RosNode, RosTopic
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.tools.recording.schema_types import message_classes

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
INTERNAL = "rmw_dds_common"
"""A package whose messages have no module in Python."""
LETTERS = "abc XYZ_09é表ソ😀"
FILLER = "structure_needs_at_least_one_member"


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


class Values:
    """Random values of ROS 2 types."""

    def __init__(self, drawn: random.Random) -> None:
        self._drawn = drawn

    def of(self, descriptor: Any) -> Any:
        drawn = self._drawn
        match plain(descriptor):
            case StructDescriptor(members=members) as struct_:
                values = {m.attribute: self.of(m.type) for m in members}
                if FILLER in values:
                    values[FILLER] = 0  # no field in rclpy
                return struct_.class_(**values)
            case ArrayDescriptor(element=element, dimensions=(length,)):
                return self._many(element, length)
            case SequenceDescriptor(element=element, bound=bound):
                return self._many(element, drawn.randint(0, min(bound or 4, 4)))
            case StringDescriptor(bound=bound):
                most = min(bound or 12, 12)
                text = "".join(drawn.choices(LETTERS, k=drawn.randint(0, most)))
                while bound is not None and len(text.encode()) > bound:
                    text = text[:-1]
                return text
            case PrimitiveDescriptor(name="boolean"):
                return drawn.random() < 0.5
            case PrimitiveDescriptor(name="float"):
                limit = FLOAT_LIMITS["float"]
                number = drawn.choice((1.0, limit)) * drawn.uniform(-1, 1)
                return struct.unpack("<f", struct.pack("<f", number))[0]
            case PrimitiveDescriptor(name="double"):
                return drawn.choice((math.pi, 1e300)) * drawn.uniform(-1, 1)
            case PrimitiveDescriptor(name="octet"):
                return drawn.randrange(256)
            case PrimitiveDescriptor(name=name):
                lowest, highest = INTEGER_RANGES[name]
                return drawn.choice((lowest, highest, drawn.randint(lowest, highest)))
        raise AssertionError(descriptor)

    def _many(self, element: Any, count: int) -> Any:
        values = [self.of(element) for _ in range(count)]
        match plain(element):
            case PrimitiveDescriptor(name="octet" | "uint8"):
                return bytes(values)
        return values


def told(value: Any) -> Any:
    """Return a value as the node of rclpy tells it."""
    if hasattr(value, "_descriptor_"):
        return {
            m.name: told(getattr(value, m.attribute))
            for m in value._descriptor_.members
            if m.name != FILLER
        }
    if isinstance(value, (str, bool, int, float)):
        return value
    return [told(each) for each in value]


def test_every_message_both_ways(peer: Node, classes: dict[str, Any]) -> None:
    """On topics of its own, to rclpy and from it."""
    from rtgen.runtime.ros2.dds import open_dds

    assert len(classes) > 125
    values = Values(random.Random(seed()))
    network = open_dds(RosNode("node", "/lab", DOMAIN))
    profile = PROFILES["default"]
    sent = {name: values.of(type_._descriptor_) for name, type_ in classes.items()}
    came: dict[str, list[bytes]] = {name: [] for name in classes}
    publish = {}
    for name, class_ in classes.items():
        there, back = (f"/{way}/{name}" for way in ("there", "back"))
        network.subscribe(RosTopic(back, class_), profile, came[name].append)
        publish[there] = name, network.publisher(RosTopic(there, class_), profile)
        peer.do("subscribe", there, name)
    for _ in classes:
        peer.event("subscribed")
    left = dict(publish)

    def exchanged() -> bool:
        """Send what has not come, on either side: readers may not be known yet."""
        for name in (name for name in classes if not came[name]):
            peer.do("publish", f"/back/{name}", name, [told(sent[name])])
            peer.event("published")
        for name, send in left.values():
            send(encoded(sent[name]))
        time.sleep(0.1)
        for event in [event for event in peer.events if event[0] == "message"]:
            if event[1] in left:
                name, _ = left.pop(event[1])
                assert event[2] == told(sent[name]), name
        return not left and all(came.values())

    until(exchanged)
    for name, class_ in classes.items():
        assert decoded(class_, came[name][0]) == sent[name], name
    network.close()


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
        with_more += len(found) > len(encoded(value))
    assert with_more


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
