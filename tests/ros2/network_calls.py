"""Calls over a network that fail, and many at once: `network_calls.py rclpy|dds|zenoh PORT`.

Run with rtgen, over rclpy in an installation of ROS 2. Prints what becomes of each in JSON.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from queue import Queue
from typing import Any

from rtgen.runtime.ros2.network import RosNetwork, RosNode, RosService
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.running.ros2_classes import message_classes

INFO, TYPE = "service_msgs/msg/ServiceEventInfo", "std_srvs/srv/SetBool"
CLASSES = message_classes(INFO, TYPE)
LONG = 100.0


def service(name: str) -> RosService:
    """Return a service that takes a boolean."""
    ends = (CLASSES[f"{TYPE}_{end}"] for end in ("Request", "Response"))
    return RosService(*ends, name, CLASSES[INFO])


def networks(kind: str, port: str) -> list[RosNetwork]:
    """Return two networks that find each other; those of Zenoh meet at the port."""
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

    place = f"tcp/127.0.0.1:{port}"
    configs = configuration(connect=None, listen=place), configuration(connect=place)
    pairs = zip(nodes, configs, strict=True)
    return [open_zenoh(node, config=config) for node, config in pairs]


def main() -> None:
    here, there = networks(*sys.argv[1:])
    results: dict[str, Any] = {}

    def client(name: str) -> Callable[..., Any]:
        """Return a function that calls a service: what it responds, or the name of the error."""
        described = service(name)
        send = here.client(described)

        def call(timeout: float, data: bool = True) -> Any:
            request = encoded(described.request(data))
            try:
                return decoded(described.reply, send(request, timeout)).message
            except ServiceError as error:
                return type(error).__name__

        return call

    results["nobody serves"] = client("/nobody")(0.2)

    def serve(name: str) -> tuple[Callable[..., Any], Queue[Any]]:
        """Serve; return a client that knows it, and how its requests are answered.

        Those with False are answered at once.
        """
        described = service(name)
        requests: Queue[Any] = Queue()

        def take(octets: bytes, reply: Any) -> None:
            def respond(text: str) -> None:
                reply(encoded(described.reply(True, text)))

            if decoded(described.request, octets).data:
                requests.put(respond)
            else:
                respond("known")

        there.serve(described, take)
        call = client(name)
        while call(1.0, False) != "known":
            pass
        return call, requests

    silent, unanswered = serve("/silent")
    results["no response"] = silent(1.0)
    held = [unanswered.get()]
    late, requests = serve("/late")
    results["late"] = late(1.0)
    requests.get()("late")
    time.sleep(0.2)
    with ThreadPoolExecutor() as pool:
        again = pool.submit(late, LONG)
        requests.get()("in time")
        results["after a late one"] = again.result()
        # Requests are answered in another order.
        order, requests = serve("/order")
        many = [pool.submit(order, LONG) for _ in range(5)]
        came = [requests.get() for _ in many]
        for number, respond in reversed(list(enumerate(came))):
            respond(str(number))
        results["in another order"] = sorted(each.result() for each in many)
        ended = pool.submit(silent, LONG)
        held.append(unanswered.get())
        here.end_calls()
        results["the run ends"] = ended.result()
        lost = pool.submit(silent, LONG)
        held.append(unanswered.get())
        there.close()
        results["the server is lost"] = lost.result()
    here.close()
    here.close()
    print(json.dumps(results))


if __name__ == "__main__":
    main()
