"""Clouds of 10 MB that were published before their readers came, beside nodes of rclpy."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import media
import pytest
from large_messages import Ends, octets_of
from rclpy_node import Events, node
from ros2_peers import Installation, installation

from rtgen.runtime.ros2.network import RosNode

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
SCRIPT = Path(__file__).with_name("large_messages.py")
SIZE = 10_000_000


class OwnEnds(Events):
    """Those of this process, over DDS."""

    name = "dds"

    def __init__(self) -> None:
        from rtgen.runtime.ros2.dds import open_dds

        super().__init__()
        self._network = open_dds(RosNode("own", "/", DOMAIN))
        self._ends = Ends(self._network, self.tell)

    def do(self, command: str, *arguments: Any) -> None:
        """Call one of their functions."""
        getattr(self._ends, command)(*arguments)

    def close(self) -> None:
        """Close the network."""
        self._network.close()


@pytest.fixture(
    scope="module",
    params=["jazzy", pytest.param("kilted", marks=pytest.mark.nightly)],
)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


@pytest.fixture(scope="module")
def hand(ros2: Installation) -> Iterator[Any]:
    with node(ros2, "hand", domain=DOMAIN, script=SCRIPT) as made:
        yield made


@pytest.fixture(scope="module", params=["rclpy", "dds"])
def own(request: pytest.FixtureRequest, ros2: Installation) -> Iterator[Any]:
    """Return ends of rtgen."""
    if request.param == "rclpy":
        with node(ros2, "rclpy", domain=DOMAIN, script=SCRIPT) as made:
            yield made
        return
    ends = OwnEnds()
    yield ends
    ends.close()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("way", ["to rclpy", "from rclpy"])
@pytest.mark.nightly
def test_a_late_reader_gets_the_whole_cloud(hand: Any, own: Any, way: str) -> None:
    topic = f"/clouds/{own.name}/{way.split()[0]}"
    writer, reader = (own, hand) if way == "to rclpy" else (hand, own)
    writer.do("send", topic, SIZE, len(topic))
    writer.event("sent", topic)
    reader.do("receive", topic)
    digest = sha256(octets_of(SIZE, len(topic))).hexdigest()
    assert reader.event("came", topic) == [topic, SIZE, digest]
