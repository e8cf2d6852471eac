"""A node of rclpy that is told what to do: run in an installation of ROS 2, without rtgen.

Each line of its input is a command in JSON, `[NAME, ARGUMENTS...]`. Each line of its output is an
event, `[NAME, VALUES...]`. Messages are mappings, sequences of octets lists of numbers.
"""

from __future__ import annotations

import importlib
import json
import sys
import threading
import time
from array import array
from typing import Any
from uuid import uuid4

import rclpy
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from unique_identifier_msgs.msg import UUID


def class_of(name: str) -> Any:
    """Return the class of an interface by its name, `std_msgs/msg/String`."""
    package, kind, last = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), last)


def plain(value: Any) -> Any:
    """Return a value of a message as JSON has it."""
    if hasattr(value, "get_fields_and_field_types"):
        return {
            name: plain(getattr(value, name))
            for name in value.get_fields_and_field_types()
        }
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, array) or type(value).__module__ == "numpy":
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def filled(message: Any, value: dict[str, Any]) -> Any:
    """Set the fields of a message; return it."""
    for name, field in value.items():
        before = getattr(message, name)
        setattr(message, name, _field(message, name, before, field))
    return message


def _field(message: Any, name: str, before: Any, field: Any) -> Any:
    if isinstance(field, dict):
        return filled(before, field)
    type_ = message.get_fields_and_field_types()[name]
    if type_ == "octet":
        return bytes([field])
    if isinstance(field, list) and "octet" in type_:
        return [bytes([each]) for each in field]
    if isinstance(field, list) and "/" in type_:
        element = type_.removeprefix("sequence<").rstrip(">").split("[")[0]
        package, last = element.split(",")[0].split("/")
        class_ = class_of(f"{package}/msg/{last}")
        return [filled(class_(), each) for each in field]
    return field


def profile(depth: int, qos: dict[str, Any] | None) -> QoSProfile:
    """Return a profile; times are in seconds."""
    values = {
        name: Duration(seconds=value) if isinstance(value, float) else value
        for name, value in (qos or {}).items()
    }
    return QoSProfile(depth=depth, **values)


class Peer:
    """The node with its ends."""

    def __init__(self, name: str, namespace: str) -> None:
        rclpy.init()
        self.node = rclpy.create_node(name, namespace=namespace)
        self.lock = threading.Lock()
        self.finished = False
        self.ends: dict[tuple[str, str], Any] = {}
        self.executor = MultiThreadedExecutor(8)
        self.executor.add_node(self.node)
        threading.Thread(target=self.executor.spin, daemon=True).start()

    def tell(self, *event: Any) -> None:
        """Write an event."""
        with self.lock:
            print(json.dumps(event), flush=True)

    def end(self, kind: str, name: str, make: Any) -> Any:
        """Return an end of this kind and name, made once."""
        if (kind, name) not in self.ends:
            self.ends[kind, name] = make()
        return self.ends[kind, name]

    def serve(self, name: str, type_: str) -> None:
        """Serve: each request is an event; the response has its fields of the same names."""

        def answer(request: Any, response: Any) -> Any:
            value = plain(request)
            self.tell("served", name, value)
            known = response.get_fields_and_field_types()
            return filled(response, {k: v for k, v in value.items() if k in known})

        self.end(
            "server",
            name,
            lambda: self.node.create_service(class_of(type_), name, answer),
        )
        self.tell("serving", name)

    def client(self, name: str, type_: str) -> Any:
        return self.end(
            "client", name, lambda: self.node.create_client(class_of(type_), name)
        )

    def wait(self, name: str, type_: str, seconds: float) -> None:
        """Wait for a service."""
        found = self.client(name, type_).wait_for_service(seconds)
        self.tell("waited", name, found)

    def call(self, name: str, type_: str, request: Any, seconds: float) -> None:
        """Call a service; the event has the response, or null without one."""
        client = self.client(name, type_)
        # A server that does not know the client yet may lose its response.
        client.wait_for_service(seconds)
        future = client.call_async(filled(class_of(type_).Request(), request))
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        found = plain(future.result()) if done.wait(seconds) else None
        self.tell("called", name, found)

    def subscribe(
        self,
        topic: str,
        type_: str,
        depth: int = 100,
        late: str | None = None,
        qos: dict[str, Any] | None = None,
    ) -> None:
        """Subscribe: each message is an event.

        `late`: messages from before come, too, as events of that name instead of the topic's.
        """
        if late:
            qos = {"durability": DurabilityPolicy.TRANSIENT_LOCAL}
        name = late or topic
        self.end(
            "reader",
            name,
            lambda: self.node.create_subscription(
                class_of(type_),
                topic,
                lambda message: self.tell("message", name, plain(message)),
                profile(depth, qos),
            ),
        )
        self.tell("subscribed", name)

    def advertise(
        self, topic: str, type_: str, depth: int, qos: dict[str, Any]
    ) -> None:
        """Make a publisher, which `publish` takes."""
        self.end(
            "writer",
            topic,
            lambda: self.node.create_publisher(
                class_of(type_), topic, profile(depth, qos)
            ),
        )
        self.tell("advertised", topic)

    def publish(
        self, topic: str, type_: str, values: list[Any], raw: bool = False
    ) -> None:
        """Publish messages once somebody reads; `raw`: as serialized by rclpy."""
        class_ = class_of(type_)
        writer = self.end(
            "writer",
            topic,
            lambda: self.node.create_publisher(class_, topic, QoSProfile(depth=100)),
        )
        ready = threading.Event()
        while not writer.get_subscription_count():
            ready.wait(0.01)
        for value in values:
            message = filled(class_(), value)
            writer.publish(serialize_message(message) if raw else message)
        self.tell("published", topic)

    def decode(self, type_: str, octets: str) -> None:
        """Decode a serialized message, and encode it again."""
        message = deserialize_message(bytes.fromhex(octets), class_of(type_))
        self.tell("decoded", plain(message), serialize_message(message).hex())

    def act(self, name: str, type_: str) -> None:
        """Serve Fibonacci's action: each goal is an event.

        Goals of order 0 are rejected, others end when they are cancelled, or by `finish`.
        """
        class_ = class_of(type_)

        def execute(goal: Any) -> Any:
            self.tell("goal", name, plain(goal.request))
            numbers = [0, 1]
            while len(numbers) <= goal.request.order:
                numbers.append(numbers[-1] + numbers[-2])
                goal.publish_feedback(class_.Feedback(sequence=numbers))
            while not (goal.is_cancel_requested or self.finished):
                time.sleep(0.005)
            if goal.is_cancel_requested:
                goal.canceled()
            else:
                goal.succeed()
            return class_.Result(sequence=numbers)

        self.end(
            "action",
            name,
            lambda: ActionServer(
                self.node,
                class_,
                name,
                execute,
                goal_callback=lambda goal: (
                    GoalResponse.ACCEPT if goal.order > 0 else GoalResponse.REJECT
                ),
                cancel_callback=lambda _: CancelResponse.ACCEPT,
                callback_group=ReentrantCallbackGroup(),
            ),
        )
        self.tell("acting", name)

    def finish(self, finished: bool) -> None:
        """Let goals succeed, those under way and later ones."""
        self.finished = finished

    def ask(self, name: str, type_: str, goal: Any, seconds: float) -> None:
        """Send a goal; the event says whether it was accepted, or null without an answer.

        Feedback and the result are events, too.
        """
        client = self.end(
            "asker", name, lambda: ActionClient(self.node, class_of(type_), name)
        )
        known = client.wait_for_server(seconds)
        identity = UUID(uuid=list(uuid4().bytes))
        text = bytes(identity.uuid).hex()
        future = client.send_goal_async(
            filled(class_of(type_).Goal(), goal),
            feedback_callback=lambda message: self.tell(
                "feedback", text, plain(message.feedback.sequence)
            ),
            goal_uuid=identity,
        )
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        handle = future.result() if done.wait(seconds) else None
        accepted = handle.accepted if handle is not None else None
        self.tell("asked", name, known, accepted, text)
        if accepted:
            self.ends["goal", text] = handle

            def end(result: Any) -> None:
                found = result.result()
                self.tell("result", text, found.status, plain(found.result.sequence))

            handle.get_result_async().add_done_callback(end)

    def cancel(self, goal: str) -> None:
        """Cancel an accepted goal."""

        def told(future: Any) -> None:
            found = future.result()
            self.tell("cancelled", goal, found.return_code, len(found.goals_canceling))

        self.ends["goal", goal].cancel_goal_async().add_done_callback(told)

    def parameters(self, node: str, values: dict[str, Any], seconds: float) -> None:
        """List, set, get and describe parameters by rclpy's own client of a node."""
        client = self.end(
            "parameters", node, lambda: AsyncParameterClient(self.node, node)
        )

        def result(future: Any) -> Any:
            done = threading.Event()
            future.add_done_callback(lambda _: done.set())
            return plain(future.result()) if done.wait(seconds) else None

        known = client.wait_for_services(seconds)
        changed = [Parameter(name, value=value) for name, value in values.items()]
        self.tell(
            "parameters",
            node,
            known,
            result(client.list_parameters()),
            result(client.set_parameters(changed)),
            result(client.get_parameters(list(values))),
            result(client.describe_parameters(list(values))),
        )

    def follow(self, topic: str, period: float) -> None:
        """Take the time from `/clock`, and publish it (std_msgs/msg/Float64) each period of it."""
        self.node.set_parameters([Parameter("use_sim_time", value=True)])
        class_ = class_of("std_msgs/msg/Float64")
        writer = self.node.create_publisher(class_, topic, QoSProfile(depth=100))

        def tell() -> None:
            now = self.node.get_clock().now().nanoseconds / 1e9
            writer.publish(class_(data=now))

        self.ends["timer", topic] = self.node.create_timer(period, tell)
        self.tell("following", topic)

    def lead(self, start: int, step: float, period: float, topic: str) -> None:
        """Publish `/clock` once somebody publishes a topic.

        Each period, from a time [s], in steps [s].
        """
        while not self.node.count_publishers(topic):
            time.sleep(0.01)
        class_ = class_of("rosgraph_msgs/msg/Clock")
        writer = self.node.create_publisher(class_, "/clock", QoSProfile(depth=1))
        count = 0

        def tell() -> None:
            nonlocal count
            now = start * 10**9 + round(count * step * 10**9)
            count += 1
            message = class_()
            message.clock.sec, message.clock.nanosec = divmod(now, 10**9)
            writer.publish(message)

        self.ends["timer", "/clock"] = self.node.create_timer(period, tell)
        self.tell("leading")

    def nodes(self) -> None:
        """Tell the names of all known nodes."""
        found = self.node.get_node_names_and_namespaces()
        self.tell(
            "nodes", sorted(f"{space.rstrip('/')}/{name}" for name, space in found)
        )


def main() -> None:
    peer = Peer(*sys.argv[1:3])
    peer.tell("ready", peer.node.get_fully_qualified_name())
    for line in sys.stdin:
        command, *arguments = json.loads(line)
        getattr(peer, command)(*arguments)
    peer.finish(True)  # threads that execute goals would be waited for


if __name__ == "__main__":
    main()
