"""Calls over a network that fail, and many at once: `network_calls.py rclpy|dds|zenoh`.

Run with rtgen, over rclpy in an installation of ROS 2. Prints what becomes of each in JSON.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from rtgen.runtime.ros2.network import RosNetwork, RosNode, RosService
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


def networks(kind: str) -> list[RosNetwork]:
    """Return two networks that find each other."""
    nodes = [
        RosNode(name, "/lab", int(os.environ["ROS_DOMAIN_ID"]))
        for name in ("here", "there")
    ]
    if kind == "rclpy":
        from rtgen.runtime.ros2.rclpy import open_rclpy

        return [open_rclpy(node) for node in nodes]
    if kind == "dds":
        from rtgen.runtime.ros2.dds import open_dds

        return [open_dds(node) for node in nodes]
    from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

    with socket.create_server(("127.0.0.1", 0)) as server:
        place = f"tcp/127.0.0.1:{server.getsockname()[1]}"
    configs = configuration(connect=None, listen=place), configuration(connect=place)
    pairs = zip(nodes, configs, strict=True)
    return [open_zenoh(node, config=config) for node, config in pairs]


def main() -> None:
    here, there = networks(sys.argv[1])
    results: dict[str, Any] = {}
    request = encoded(service("").request(True))

    def call(name: str, timeout: float) -> Callable[[], object]:
        send = here.client(service(name))

        def answer() -> object:
            return decoded(service(name).reply, send(request, timeout)).message

        return answer

    results["nobody serves"] = outcome(call("/nobody", 0.2))
    asked = threading.Event()
    kept: list[Any] = []

    def serve(name: str, on_request: Callable[[bytes, Any], object]) -> None:
        """Serve, and wait until requests come; those with False are answered at once."""
        served = service(name)

        def take(octets: bytes, reply: Any) -> None:
            if decoded(served.request, octets).data:
                on_request(octets, reply)
            else:
                reply(encoded(served.reply(True, "known")))

        there.serve(served, take)
        probe = here.client(served)
        known = encoded(served.request(False))
        while not isinstance(outcome(lambda: probe(known, 1.0)), bytes):
            pass

    def silent(octets: bytes, reply: Any) -> None:
        kept.append(reply)
        asked.set()

    serve("/silent", silent)
    results["no response"] = outcome(call("/silent", 1.0))
    replies: list[Any] = []
    serve("/late", lambda octets, reply: replies.append(reply))
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
        held: list[Any] = []
        serve("/order", lambda octets, reply: held.append(reply))
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
