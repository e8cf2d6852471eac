"""QoS of topics over Zenoh: what tokens say of peers, deadlines, lost messages, identifiers."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from types import ModuleType
from typing import Any
from uuid import uuid4

import pytest
from free_ports import free_port
from patience import until

from rtgen.facts import ros_zenoh
from rtgen.facts.ros_qos import PROFILES, Durability, Liveliness, Profile
from rtgen.facts.ros_zenoh import Attachment
from rtgen.runtime.ros2.network import RosNetwork, RosNode, RosTopic
from rtgen.runtime.ros2.types import encoded

zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
pytest.importorskip("xxhash", reason="xxhash is not installed")

pytestmark = [pytest.mark.waits]

DOMAIN = 7


@pytest.fixture(scope="module")
def place() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture(scope="module")
def near(place: str) -> Iterator[RosNetwork]:
    from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

    node = RosNode("node", "/lab", DOMAIN)
    made = open_zenoh(node, config=configuration(connect=None, listen=place))
    yield made
    made.close()


@pytest.fixture(scope="module")
def far(near: RosNetwork, place: str) -> Iterator[RosNetwork]:
    from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

    made = open_zenoh(
        RosNode("peer", "/far", DOMAIN), config=configuration(connect=place)
    )
    yield made
    made.close()


@pytest.fixture
def warnings(caplog: pytest.LogCaptureFixture) -> Any:
    def found(topic: str) -> list[str]:
        return [
            record.getMessage()
            for record in caplog.records
            if record.levelno == logging.WARNING
            and record.getMessage().startswith(f"{topic}:")
        ]

    return found


def test_what_does_not_fit_is_said_once_by_each_side_and_passes(
    near: RosNetwork, far: RosNetwork, messages: ModuleType, warnings: Any
) -> None:
    topic = RosTopic(f"/unfit_{uuid4().hex}", messages["std_msgs"].Float32)
    strong = Profile(durability=Durability.TRANSIENT_LOCAL, deadline=10**9)
    received: list[bytes] = []
    near.subscribe(topic, strong, received.append)
    publish = far.publisher(topic, PROFILES["sensor_data"])
    until(lambda: len(warnings(topic.name)) == 2)
    until(lambda: publish(encoded(topic.type(1.0))) or received)
    texts = warnings(topic.name)
    assert len(texts) == 2
    for text in texts:
        assert (
            "the subscription of node /lab/node asks for more than the publisher of node "
            "/far/peer offers, so it would get nothing over DDS: reliability is best_effort at "
            "the publisher, reliable at the subscription, durability is volatile at the "
            "publisher, transient_local at the subscription, deadline is inf at the publisher, 1 "
            "at the subscription; state "
        ) in text
    assert sum('reliability = "best_effort"' in t.split("for this")[0] for t in texts)


def test_ends_that_fit_are_not_reported(
    near: RosNetwork, far: RosNetwork, messages: ModuleType, warnings: Any
) -> None:
    topic = RosTopic(f"/fits_{uuid4().hex}", messages["std_msgs"].Float32)
    received: list[bytes] = []
    near.subscribe(topic, PROFILES["sensor_data"], received.append)
    publish = far.publisher(topic, Profile())
    until(lambda: publish(encoded(topic.type(1.0))) or received)
    assert not warnings(topic.name)


def test_missed_deadlines(
    near: RosNetwork, far: RosNetwork, messages: ModuleType, warnings: Any
) -> None:
    topic = RosTopic(f"/late_{uuid4().hex}", messages["std_msgs"].Float32)
    strict = Profile(deadline=50_000_000)
    received: list[bytes] = []
    subscription = near.subscribe(topic, strict, received.append)
    publish = far.publisher(topic, strict)
    until(lambda: publish(encoded(topic.type(1.0))) or received)
    until(lambda: subscription.missed_deadlines >= 3)
    until(lambda: len(warnings(topic.name)) == 2)
    assert {text.split(" within")[0] for text in warnings(topic.name)} == {
        f"{topic.name}: no message came",
        f"{topic.name}: nothing was published",
    }


def test_gaps_in_the_numbers_of_a_publisher_are_lost_messages(
    near: RosNetwork, place: str, messages: ModuleType
) -> None:
    topic = RosTopic(f"/gaps_{uuid4().hex}", messages["std_msgs"].Float32)
    received: list[bytes] = []
    subscription = near.subscribe(topic, Profile(), received.append)
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["{place}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    octets = encoded(topic.type(1.0))
    key = ros_zenoh.key_expression(DOMAIN, topic.name, topic.type_name, topic.type_hash)
    with zenoh.open(config) as session:
        publisher = session.declare_publisher(key)
        until(lambda: publisher.matching_status.matching)
        # Two publishers; the second one comes late, and each has its own numbers.
        for gid, number in ((1, 1), (1, 2), (2, 70), (1, 5), (2, 71), (1, 5), (1, 9)):
            sent = Attachment(number, 0, bytes([gid]) * 16)
            publisher.put(octets, attachment=ros_zenoh.attachment(sent))
        publisher.put(octets, attachment=b"no attachment of rmw_zenoh")
        publisher.put(octets)
        until(lambda: len(received) == 9)
    assert subscription.lost == 2 + 3


def test_what_zenoh_has_nothing_for_is_said(
    near: RosNetwork, messages: ModuleType, warnings: Any
) -> None:
    topic = RosTopic(f"/ignored_{uuid4().hex}", messages["std_msgs"].Float32)
    profile = Profile(
        lifespan=10**9, liveliness=Liveliness.MANUAL_BY_TOPIC, lease=10**9
    )
    near.publisher(topic, profile)
    [text] = warnings(topic.name)
    assert text.endswith(": lifespan, lease, liveliness has no effect over Zenoh")


GIDS = {
    "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MP/%/%/talker/%chatter/"
    "std_msgs::msg::dds_::String_/RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e94"
    "8f6b1a18/::,10:,:,:,,": "6b722eb99c993f2f5516bada05e9086c",
    "a": "1f4e961eb632c6e63468f15a70af6fa9",
    "ab/cd": "b860f44c26f83e0ca820f71e55326ff0",
    "x" * 300: "5435c87d60b4d1a57abcd72aea375212",
}
"""Texts, the first one a token, with the identifiers by rmw_zenoh's simplified_xxhash3.cpp."""


@pytest.mark.parametrize("token", GIDS)
def test_identifiers_of_entities(token: str) -> None:
    from rtgen.runtime.ros2.zenoh_topics import gid_of

    assert gid_of(token).hex() == GIDS[token]
