"""QoS of topics during a run, beside nodes of rclpy on Fast DDS."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from itertools import count
from types import ModuleType
from typing import Any
from uuid import uuid4

import media
import pytest
from patience import until
from rclpy_node import Node, node
from ros2_peers import DISTRIBUTIONS, installation

from rtgen.facts.ros_qos import (
    PROFILES,
    Durability,
    Liveliness,
    Profile,
    Reliability,
    misfits,
)
from rtgen.runtime import Component, RealClock, System
from rtgen.runtime.ros2.network import RosNode, RosTopic
from rtgen.runtime.ros2.ports import Joint, RosPorts
from rtgen.runtime.ros2.types import encoded

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
FLOAT = "std_msgs/msg/Float32"
POLICIES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "reliability": (
        {"reliability": Reliability.BEST_EFFORT},
        {"reliability": Reliability.RELIABLE},
    ),
    "durability": (
        {"durability": Durability.VOLATILE},
        {"durability": Durability.TRANSIENT_LOCAL},
    ),
    "deadline": ({"deadline": 2 * 10**9}, {"deadline": 10**9}),
    "liveliness": (
        {"liveliness": Liveliness.AUTOMATIC},
        {"liveliness": Liveliness.MANUAL_BY_TOPIC},
    ),
    "lease": ({"lease": 2 * 10**9}, {"lease": 10**9}),
}
"""The policies that are compared, each with a weaker and a stronger value."""


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def peer(request: pytest.FixtureRequest) -> Iterator[Node]:
    made = installation(request.param)
    with node(made, "peer", "/far", domain=DOMAIN) as running:
        yield running


@pytest.fixture(scope="module")
def network(peer: Node) -> Iterator[Any]:
    from rtgen.runtime.ros2.dds import open_dds

    made = open_dds(RosNode("node", "/lab", DOMAIN))
    yield made
    made.close()


@pytest.fixture
def warnings(caplog: pytest.LogCaptureFixture) -> Any:
    """Return a function for the warnings that begin with a topic."""

    def found(topic: str) -> list[str]:
        return [
            record.getMessage()
            for record in caplog.records
            if record.levelno == logging.WARNING
            and record.getMessage().startswith(f"{topic}:")
        ]

    return found


def in_rclpy(values: dict[str, Any]) -> dict[str, Any]:
    """Return values of a profile by rclpy's words, with times in seconds."""
    words = {"lease": "liveliness_lease_duration"}
    return {
        words.get(key, key): value / 1e9 if key in ("deadline", "lease") else int(value)
        for key, value in values.items()
    }


def publish_until(
    peer: Node, topic: str, is_there: Callable[[], object], numbers: Iterator[int]
) -> None:
    """Let a node publish values until one arrives: at first only one side knows the other."""

    def arrived() -> object:
        peer.do("publish", topic, FLOAT, [{"data": float(next(numbers))}])
        peer.event("published")
        return is_there()

    until(arrived)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("writes", [False, True])
def test_what_does_not_fit_is_said_once_with_both_values(
    writes: bool,
    policy: str,
    peer: Node,
    network: Any,
    messages: ModuleType,
    warnings: Any,
) -> None:
    type_ = messages["std_msgs"].Float32
    topic = f"/{policy}_{uuid4().hex}"
    weak, strong = POLICIES[policy]
    mine, theirs = (weak, strong) if writes else (strong, weak)
    profile = Profile()._replace(**mine)
    if writes:
        peer.do("subscribe", topic, FLOAT, 10, None, in_rclpy(theirs))
        peer.event("subscribed")
        network.publisher(RosTopic(topic, type_), profile)
    else:
        network.subscribe(RosTopic(topic, type_), profile, lambda octets: None)
        peer.do("advertise", topic, FLOAT, 10, in_rclpy(theirs))
        peer.event("advertised")
    until(lambda: warnings(topic))
    [text] = warnings(topic)
    here, there = "node /lab/node", "node /far/peer"
    publisher, subscription = (here, there) if writes else (there, here)
    assert f"the subscription of {subscription} asks for more than" in text
    assert f"the publisher of {publisher} offers" in text
    other = Profile()._replace(**theirs)
    ends = (profile, other) if writes else (other, profile)
    [unfit] = misfits(*ends)
    assert unfit.policy == policy
    assert f"{policy} is {unfit.offered} at the publisher, {unfit.requested} at" in text
    assert f"{policy} = " in text
    # A subscription that requests no more than is offered.
    modest = Profile()._replace(**weak)
    network.subscribe(RosTopic(topic, type_), modest, lambda octets: None)
    assert warnings(topic) == [text]


@pytest.mark.sampled(1)
def test_pairs_that_fit_are_not_reported(
    peer: Node, network: Any, messages: ModuleType, warnings: Any
) -> None:
    """The same ends receive: what is discovered is processed before."""
    topic = f"/fits_{uuid4().hex}"
    received: list[bytes] = []
    type_ = messages["std_msgs"].Float32
    for name in ("default", "sensor_data"):
        network.subscribe(RosTopic(topic, type_), PROFILES[name], received.append)
    publish_until(peer, topic, lambda: len(received) >= 2, count())
    assert not warnings(topic)


NUMBER = 5500


@pytest.mark.sampled(2)
@pytest.mark.parametrize("depth", [1, 10, 1000])
def test_received_and_lost_are_all_that_was_sent(
    depth: int, peer: Node, messages: ModuleType
) -> None:
    """A burst that is faster than the reader; the buffer of the port is of 8."""
    from rtgen.runtime.ros2.dds import open_dds

    topic = f"/burst_{uuid4().hex}"
    type_ = messages["std_msgs"].Float32
    component = Component("Reader0")
    port = component.add_in_port("values", type_)
    network = open_dds(RosNode("burst", "/lab", DOMAIN))
    system = System(RealClock())
    system.add(component, 100.0)
    ports = RosPorts(network, [Joint(port, topic, Profile(depth))])
    try:
        numbers = count()
        publish_until(peer, topic, port.is_new, numbers)
        begin = next(numbers)
        end = begin + NUMBER
        # The last one before the burst.
        until(lambda: port.is_new() and port.read().data == begin - 1)
        first, before = begin - 1, port.lost
        values = [{"data": float(number)} for number in range(begin, end)]
        peer.do("publish", topic, FLOAT, values)
        peer.event("published")
        received, last = 1, first

        def all_there() -> bool:
            nonlocal received, last
            while port.is_new():
                value = int(port.read().data)
                assert value > last
                last = value
                received += 1
            return last == end - 1

        until(all_there)
        assert received + port.lost - before == end - first
    finally:
        ports.close()
        system.close()


@pytest.mark.sampled(1)
def test_missed_deadlines_are_counted_and_reported(
    peer: Node, network: Any, messages: ModuleType, warnings: Any
) -> None:
    type_ = messages["std_msgs"].Float32
    came, sent = (f"/{word}_{uuid4().hex}" for word in ("came", "sent"))
    strict = Profile(deadline=50_000_000)
    received: list[bytes] = []
    subscription = network.subscribe(RosTopic(came, type_), strict, received.append)
    peer.do("advertise", came, FLOAT, 10, {"deadline": 0.05})
    publish_until(peer, came, lambda: received, count())
    publish = network.publisher(RosTopic(sent, type_), strict)
    publish(encoded(type_(1.0)))
    until(lambda: subscription.missed_deadlines >= 5)
    until(lambda: warnings(came) and warnings(sent))
    assert "no message came within its deadline of 0.05 s" in warnings(came)[0]
    assert "nothing was published within its deadline of 0.05 s" in warnings(sent)[0]
    # The next report comes later than the next misses.
    before = subscription.missed_deadlines
    until(lambda: subscription.missed_deadlines > before + 20)
    assert len(warnings(came)) == len(warnings(sent)) == 1


@pytest.mark.sampled(1)
def test_lost_liveliness_is_counted_and_reported(
    peer: Node, network: Any, messages: ModuleType, warnings: Any
) -> None:
    type_ = messages["std_msgs"].Float32
    theirs, own = (f"/{word}_{uuid4().hex}" for word in ("theirs", "own"))
    profile = Profile(liveliness=Liveliness.MANUAL_BY_TOPIC, lease=200_000_000)
    received: list[bytes] = []
    subscription = network.subscribe(RosTopic(theirs, type_), profile, received.append)
    qos = {"liveliness": 3, "liveliness_lease_duration": 0.2}
    peer.do("advertise", theirs, FLOAT, 10, qos)
    publish_until(peer, theirs, lambda: received, count())
    publish = network.publisher(RosTopic(own, type_), profile)
    publish(encoded(type_(1.0)))
    until(lambda: subscription.lost_liveliness)
    until(lambda: warnings(theirs) and warnings(own))
    assert "a publisher showed no sign of life within its lease" in warnings(theirs)[0]
    assert "this publisher showed no sign of life within its lease" in warnings(own)[0]
