"""A teleoperation program for a base, as it is written with rclpy: run in an installation of ROS 2.

It commands 0.2 m/s until the base has moved 0.3 m, then nothing, and waits until the base stands.
Its last line of output is what it has received, in JSON.
"""

from __future__ import annotations

import json
import sys

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState

SPEED, WAY = 0.2, 0.3


class Teleop(Node):
    """Drives until the odometry says that it is enough."""

    def __init__(self, *, stamped: bool) -> None:
        super().__init__("teleop")
        self.stamped = stamped
        self.received: dict[str, int] = {}
        self.way = self.angle = 0.0
        self.frames: tuple[str, str] = ("", "")
        self.joints: list[str] = []
        self.diagnosed: dict[str, str] = {}
        self.stands = self.wheels_stand = False
        self.driving = True
        self.sender = self.create_publisher(
            TwistStamped if stamped else Twist, "/cmd_vel", 10
        )
        for type_, topic, taken in (
            (Odometry, "/odom", self.on_odom),
            (JointState, "/joint_states", self.on_joints),
            (DiagnosticArray, "/diagnostics", self.on_diagnostics),
        ):
            self.create_subscription(type_, topic, taken, 10)
        self.create_timer(0.1, self.command)

    def command(self) -> None:
        if not self.driving:
            return
        message = TwistStamped() if self.stamped else Twist()
        twist = message.twist if self.stamped else message
        if self.stamped:
            message.header.stamp = self.get_clock().now().to_msg()
        twist.linear.x = SPEED
        self.sender.publish(message)

    def count(self, topic: str) -> None:
        self.received[topic] = self.received.get(topic, 0) + 1

    def on_odom(self, message: Odometry) -> None:
        self.count("/odom")
        self.way = message.pose.pose.position.x
        if self.way >= WAY:
            self.driving = False
        speed = message.twist.twist.linear.x
        self.stands = not self.driving and speed == 0.0
        self.frames = message.header.frame_id, message.child_frame_id

    def on_joints(self, message: JointState) -> None:
        self.count("/joint_states")
        self.joints = list(message.name)
        self.angle = message.position[0]
        self.wheels_stand = message.velocity[0] == 0.0

    def on_diagnostics(self, message: DiagnosticArray) -> None:
        self.count("/diagnostics")
        self.diagnosed = {each.name: each.message for each in message.status}

    @property
    def is_well(self) -> bool:
        """Whether the last diagnostics say so, and that the base stands."""
        texts = {**self.diagnosed}
        stands = "no velocity" in texts.pop("Base0: command", "")
        return stands and {*texts.values()} <= {"enabled", "answers"}


def main() -> None:
    rclpy.init()
    node = Teleop(stamped=sys.argv[1] == "stamped")
    while not (node.stands and node.wheels_stand and node.is_well):
        rclpy.spin_once(node, timeout_sec=0.1)
    # Those of both topics that tell of the base after it stood.
    enough = {t: node.received[t] + 3 for t in ("/odom", "/joint_states")}
    while not node.is_well or any(node.received[t] < n for t, n in enough.items()):
        rclpy.spin_once(node, timeout_sec=0.1)
    print(
        json.dumps(
            {
                "received": node.received,
                "way": node.way,
                "angle": node.angle,
                "frames": node.frames,
                "joints": node.joints,
                "diagnosed": node.diagnosed,
            }
        )
    )
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
