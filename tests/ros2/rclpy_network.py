"""rtgen's network of rclpy that is told what to do: run in an installation of ROS 2 with rtgen.

Commands and events are lines as those of `rclpy_peer.py`; profiles are lists, as in `Profile`.
"""

from __future__ import annotations

import json
import logging
import os
import sys
import threading
from typing import Any

from rtgen.facts.ros_qos import Durability, History, Liveliness, Profile, Reliability
from rtgen.runtime.ros2.network import RosNode, RosTopic
from rtgen.runtime.ros2.rclpy import open_rclpy
from rtgen.runtime.ros2.types import encoded
from rtgen.tools.running.ros2_classes import message_classes

FLOAT = "std_msgs/msg/Float32"


class Told(logging.Handler):
    """Tells warnings of the runtime as events."""

    def emit(self, record: logging.LogRecord) -> None:
        tell("warning", record.getMessage())


LOCK = threading.Lock()


def tell(*event: Any) -> None:
    """Write an event."""
    with LOCK:
        print(json.dumps(event), flush=True)


def profile(values: list[Any]) -> Profile:
    """Return a profile."""
    depth, reliability, durability, history, deadline, lifespan, kind, lease = values
    return Profile(
        *(depth, Reliability(reliability), Durability(durability), History(history)),
        *(deadline, lifespan, Liveliness(kind), lease),
    )


class Ends:
    """The ends of the network."""

    def __init__(self, name: str, namespace: str) -> None:
        domain = int(os.environ["ROS_DOMAIN_ID"])
        self.network = open_rclpy(RosNode(name, namespace, domain))
        self.type = message_classes(FLOAT)[FLOAT]
        self.readers: dict[str, Any] = {}
        self.received: dict[str, list[bytes]] = {}
        self.writers: dict[str, Any] = {}
        self.may_take = threading.Event()
        self.may_take.set()

    def subscribe(self, topic: str, values: list[Any]) -> None:
        """Subscribe."""
        received = self.received.setdefault(topic, [])

        def take(octets: bytes) -> None:
            received.append(octets)
            self.may_take.wait()

        described = RosTopic(topic, self.type)
        reader = self.network.subscribe(described, profile(values), take)
        self.readers[topic] = reader
        tell("subscribed", topic)

    def advertise(self, topic: str, values: list[Any]) -> None:
        """Make a publisher."""
        described = RosTopic(topic, self.type)
        self.writers[topic] = self.network.publisher(described, profile(values))
        tell("advertised", topic)

    def publish(self, topic: str, number: int) -> None:
        """Publish values."""
        for value in range(number):
            self.writers[topic](encoded(self.type(float(value))))
        tell("published", topic)

    def hold(self, holds: bool) -> None:
        """Let the subscriptions wait in their next message, or go on."""
        if holds:
            self.may_take.clear()
        else:
            self.may_take.set()
        tell("holds", holds)

    def counts(self, topic: str) -> None:
        """Tell what a subscription has counted."""
        reader = self.readers[topic]
        tell(
            *("counts", topic, len(self.received[topic]), reader.lost),
            *(reader.missed_deadlines, reader.lost_liveliness),
        )


def main() -> None:
    log = logging.getLogger("rtgen.runtime")
    log.addHandler(Told())
    ends = Ends(*sys.argv[1:3])
    tell("ready", sys.argv[1])
    for line in sys.stdin:
        command, *arguments = json.loads(line)
        getattr(ends, command)(*arguments)
    ends.network.close()


if __name__ == "__main__":
    main()
