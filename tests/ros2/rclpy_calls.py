"""Calls over the network of rclpy that fail, and many at once: run in an installation of ROS 2.

Prints what becomes of each in JSON.
"""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from rtgen.runtime.ros2.network import RosNetwork, RosNode, RosService
from rtgen.runtime.ros2.rclpy import open_rclpy
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.running.ros2_classes import message_classes

INFO, TYPE = "service_msgs/msg/ServiceEventInfo", "std_srvs/srv/SetBool"
CLASSES = message_classes(INFO, TYPE)
LONG = 30.0


def service(name: str) -> RosService:
    """Return a service that takes a boolean."""
    ends = (CLASSES[f"{TYPE}_{end}"] for end in ("Request", "Response"))
    return RosService(*ends, name, CLASSES[INFO])


def outcome(call: Callable[[], object]) -> Any:
    """Return the name of the error, or the result."""
    try:
        return call()
    except ServiceError as error:
        return type(error).__name__


def opened(name: str) -> RosNetwork:
    return open_rclpy(RosNode(name, "/lab", int(os.environ["ROS_DOMAIN_ID"])))


def main() -> None:
    here, there = opened("here"), opened("there")
    results: dict[str, Any] = {}
    request = encoded(service("").request(True))

    def call(name: str, timeout: float) -> Callable[[], object]:
        send = here.client(service(name))

        def answer() -> object:
            return decoded(service(name).reply, send(request, timeout)).message

        return answer

    results["nobody serves"] = outcome(call("/nobody", 0.2))
    asked = threading.Event()

    def silent(octets: bytes, reply: Any) -> None:
        asked.set()

    there.serve(service("/silent"), silent)
    results["no response"] = outcome(call("/silent", 2.0))
    replies: list[Any] = []
    there.serve(service("/late"), lambda octets, reply: replies.append(reply))
    late = call("/late", 1.0)
    results["late"] = outcome(late)
    response = encoded(service("/late").reply(True, "late"))
    replies[0](response)
    time.sleep(0.2)
    with ThreadPoolExecutor() as pool:
        again = pool.submit(outcome, late)
        while len(replies) < 2:
            time.sleep(0.01)
        replies[1](encoded(service("/late").reply(True, "in time")))
        results["after a late one"] = again.result()
        # Requests are answered in another order.
        there.serve(service("/order"), lambda octets, reply: held.append(reply))
        held: list[Any] = []
        order = call("/order", LONG)
        many = [pool.submit(outcome, order) for _ in range(5)]
        while len(held) < 5:
            time.sleep(0.01)
        for number, reply in reversed(list(enumerate(held))):
            reply(encoded(service("/order").reply(True, str(number))))
        results["in another order"] = sorted(str(each.result()) for each in many)
        asked.clear()
        ended = pool.submit(outcome, call("/silent", LONG))
        asked.wait()
        here.end_calls()
        results["the run ends"] = ended.result()
        asked.clear()
        lost = pool.submit(outcome, call("/silent", LONG))
        asked.wait()
        there.close()
        results["the server is lost"] = lost.result()
    here.close()
    here.close()
    print(json.dumps(results))


if __name__ == "__main__":
    main()
