"""A node beside a launched system: run in an installation of ROS 2, without rtgen.

    colcon_peer.py [COMPONENT]

makes the component active if one is named, and waits until it has received a load. The output is
its mass.
"""

from __future__ import annotations

import sys

import rclpy
from lab_msgs.msg import Load
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("colcon_peer")
    masses: list[float] = []
    node.create_subscription(Load, "/lab/load", lambda m: masses.append(m.mass), 10)
    for name in sys.argv[1:]:
        client = node.create_client(ChangeState, f"{name}/change_state")
        while not client.wait_for_service(1.0):
            pass
        request = ChangeState.Request()
        request.transition.id = Transition.TRANSITION_ACTIVATE
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future)
        assert future.result().success
    while not masses:
        rclpy.spin_once(node)
    print(masses[0], flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
