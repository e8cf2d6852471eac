"""QoS of topics over rtgen's network of rclpy, beside nodes of rclpy on Fast DDS."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import media
import pytest
from patience import until
from rclpy_node import Node, node
from ros2_peers import Installation, installation
from test_qos import FLOAT, POLICIES, in_rclpy

from rtgen.facts.ros_qos import Liveliness, Profile, misfits

pytestmark = [pytest.mark.peer, pytest.mark.waits]

SCRIPT = Path(__file__).with_name("rclpy_network.py")
DOMAIN = media.own_domain()


@pytest.fixture(
    scope="module", params=["jazzy", pytest.param("kilted", marks=pytest.mark.nightly)]
)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


@pytest.fixture(scope="module")
def peer(ros2: Installation) -> Iterator[Node]:
    with node(ros2, "peer", "/far", domain=DOMAIN) as running:
        yield running


@pytest.fixture(scope="module")
def network(ros2: Installation) -> Iterator[Node]:
    with node(ros2, "node", "/lab", domain=DOMAIN, script=SCRIPT) as running:
        yield running


def warning(network: Node, topic: str) -> str:
    """Wait for the warning about a topic."""

    def found() -> list[list[Any]]:
        told = [*network.events]
        return [e for e in told if e[0] == "warning" and e[1].startswith(f"{topic}:")]

    until(lambda: bool(found()))
    [[_, text]] = found()
    return str(text)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("writes", [False, True])
def test_what_does_not_fit_is_said_once_with_both_values(
    writes: bool, policy: str, peer: Node, network: Node
) -> None:
    topic = f"/{policy}_{uuid4().hex}"
    weak, strong = POLICIES[policy]
    mine, theirs = (weak, strong) if writes else (strong, weak)
    profile = Profile()._replace(**mine)
    if writes:
        peer.do("subscribe", topic, FLOAT, 10, None, in_rclpy(theirs))
        peer.event("subscribed")
        network.do("advertise", topic, profile)
    else:
        network.do("subscribe", topic, profile)
        peer.do("advertise", topic, FLOAT, 10, in_rclpy(theirs))
        peer.event("advertised")
    text = warning(network, topic)
    here, there = "node /lab/node", "node /far/peer"
    publisher, subscription = (here, there) if writes else (there, here)
    assert f"the subscription of {subscription} asks for more than" in text
    assert f"the publisher of {publisher} offers" in text
    other = Profile()._replace(**theirs)
    ends = (profile, other) if writes else (other, profile)
    [unfit] = misfits(*ends)
    assert f"{policy} is {unfit.offered} at the publisher, {unfit.requested} at" in text


def publish_until_heard(peer: Node, network: Node, topic: str) -> int:
    """Let the peer publish until a message arrives; return the number of those received."""

    def heard() -> int:
        peer.do("publish", topic, FLOAT, [{"data": 1.0}])
        peer.event("published")
        network.do("counts", topic)
        return int(network.event("counts", topic)[1])

    return int(until(heard))


@pytest.mark.nightly
def test_what_the_history_drops_is_counted(peer: Node, network: Node) -> None:
    topic = f"/burst_{uuid4().hex}"
    network.do("subscribe", topic, Profile(10))
    network.event("subscribed", topic)
    publish_until_heard(peer, network, topic)
    network.do("hold", True)
    network.event("holds")
    peer.do("publish", topic, FLOAT, [{"data": float(n)} for n in range(500)])
    peer.event("published")
    network.do("hold", False)
    network.event("holds")

    def counted() -> bool:
        network.do("counts", topic)
        _, received, lost, *_ = network.event("counts")
        return bool(lost > 400 and received + lost > 500)

    until(counted)


@pytest.mark.nightly
def test_deadlines_and_liveliness(peer: Node, network: Node) -> None:
    came, sent = (f"/{word}_{uuid4().hex}" for word in ("came", "sent"))
    strict = Profile(deadline=50_000_000)
    network.do("subscribe", came, strict)
    network.event("subscribed", came)
    peer.do("advertise", came, FLOAT, 10, {"deadline": 0.05})
    publish_until_heard(peer, network, came)
    network.do("advertise", sent, strict)
    network.do("publish", sent, 1)
    assert "no message came within its deadline of 0.05 s" in warning(network, came)
    assert "nothing was published within its deadline" in warning(network, sent)
    network.do("counts", came)
    assert network.event("counts", came)[3] >= 1

    theirs, own = (f"/{word}_{uuid4().hex}" for word in ("theirs", "own"))
    manual = Profile(liveliness=Liveliness.MANUAL_BY_TOPIC, lease=200_000_000)
    network.do("subscribe", theirs, manual)
    network.event("subscribed", theirs)
    qos = {"liveliness": 3, "liveliness_lease_duration": 0.2}
    peer.do("advertise", theirs, FLOAT, 10, qos)
    publish_until_heard(peer, network, theirs)
    network.do("advertise", own, manual)
    network.do("publish", own, 1)
    assert "a publisher showed no sign of life" in warning(network, theirs)
    assert "this publisher showed no sign of life" in warning(network, own)
