"""Ends that send and receive a large cloud, by rclpy or by rtgen; run in an installation of ROS 2.

    python large_messages.py hand|rclpy

Commands and events are lines as those of `rclpy_peer.py`. Publishers are transient local: a
subscription that comes later gets the cloud, too.
"""

from __future__ import annotations

import json
import os
import random
import sys
from collections.abc import Callable
from hashlib import sha256
from typing import Any

TYPE = "sensor_msgs/msg/PointCloud2"
Tell = Callable[..., None]


def octets_of(size: int, seed: int) -> bytes:
    """Return random octets, equal in all processes."""
    return random.Random(seed).randbytes(size)


def told(cloud: Any) -> tuple[str, int, str]:
    """Return what tells a cloud: its frame, the number of its octets, and their digest."""
    octets = bytes(cloud.data)
    return cloud.header.frame_id, len(octets), sha256(octets).hexdigest()


class Ends:
    """Ends on a network of rtgen."""

    def __init__(self, network: Any, tell: Tell) -> None:
        from rtgen.facts.ros_qos import PROFILES
        from rtgen.tools.running.ros2_classes import message_classes

        self._network = network
        self._tell = tell
        self._class = message_classes(TYPE)[TYPE]
        self._profile = PROFILES["map"]

    def send(self, topic: str, size: int, seed: int) -> None:
        """Publish a cloud."""
        from rtgen.runtime.ros2.network import RosTopic
        from rtgen.runtime.ros2.types import blank, encoded

        cloud = blank(self._class._descriptor_)
        cloud.header.frame_id = topic
        cloud.data = octets_of(size, seed)
        publish = self._network.publisher(RosTopic(topic, self._class), self._profile)
        publish(encoded(cloud))
        self._tell("sent", topic)

    def receive(self, topic: str) -> None:
        """Subscribe: each cloud is an event."""
        from rtgen.runtime.ros2.network import RosTopic
        from rtgen.runtime.ros2.types import decoded

        def take(octets: bytes) -> None:
            self._tell("came", *told(decoded(self._class, octets)))

        self._network.subscribe(RosTopic(topic, self._class), self._profile, take)


class ByHand:
    """Ends of a node of rclpy."""

    def __init__(self, tell: Tell) -> None:
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import PointCloud2

        rclpy.init()
        self._tell = tell
        self._class = PointCloud2
        local = DurabilityPolicy.TRANSIENT_LOCAL
        self._profile = QoSProfile(depth=1, durability=local)
        self._node = rclpy.create_node("hand")

    def send(self, topic: str, size: int, seed: int) -> None:
        """See `Ends`."""
        cloud = self._class()
        cloud.header.frame_id = topic
        cloud.data = octets_of(size, seed)
        self._node.create_publisher(self._class, topic, self._profile).publish(cloud)
        self._tell("sent", topic)

    def receive(self, topic: str) -> None:
        """Subscribe, and wait for a cloud."""
        import rclpy
        from rclpy.task import Future

        came = Future()

        def take(cloud: Any) -> None:
            self._tell("came", *told(cloud))
            came.set_result(None)

        self._node.create_subscription(self._class, topic, take, self._profile)
        rclpy.spin_until_future_complete(self._node, came)


def main() -> None:
    def tell(*event: Any) -> None:
        print(json.dumps(event), flush=True)

    ends: Any
    if sys.argv[1] == "hand":
        ends = ByHand(tell)
    else:
        from rtgen.runtime.ros2.network import RosNode
        from rtgen.runtime.ros2.rclpy import open_rclpy

        domain = int(os.environ["ROS_DOMAIN_ID"])
        ends = Ends(open_rclpy(RosNode("own", "/", domain)), tell)
    tell("ready", sys.argv[1])
    for line in sys.stdin:
        command, *arguments = json.loads(line)
        getattr(ends, command)(*arguments)


if __name__ == "__main__":
    main()
