"""Prints what `~/get_type_description` of a node of rclpy answers: run in an installation of ROS 2.

The input is a line of JSON: a number, and pairs `[TYPE, HASH]` that the node is asked for. It uses
the types of that number of them.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy_peer import class_of, plain
from type_description_interfaces.srv import GetTypeDescription


def main() -> None:
    used: int
    asked: list[list[str]]
    used, *asked = json.loads(sys.stdin.readline())
    rclpy.init()
    node, caller = rclpy.create_node("described"), rclpy.create_node("caller")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.add_node(caller)
    ends: list[Any] = []
    for number, (name, _) in enumerate(asked[:used]):
        topic = f"/e{number}"
        if "/msg/" in name:
            ends.append(node.create_publisher(class_of(name), topic, 1))
        else:
            ends.append(
                node.create_service(class_of(name), topic, lambda _, answer: answer)
            )
    client = caller.create_client(GetTypeDescription, "/described/get_type_description")
    client.wait_for_service()
    for name, type_hash in asked:
        request = GetTypeDescription.Request(type_name=name, type_hash=type_hash)
        future = client.call_async(request)
        executor.spin_until_future_complete(future)
        print(json.dumps(plain(future.result())), flush=True)
    executor.shutdown()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
