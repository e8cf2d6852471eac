"""A node on one of rtgen's own networks, which is told what to do as that of rclpy is."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import uuid4

from random_values import told, value_of
from rclpy_node import Events

from rtgen.compiler.kit.resources import ros_file
from rtgen.facts.ros_qos import PROFILES
from rtgen.ros2.rosidl import load
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.ros2.network import RosNetwork, RosService, RosTopic
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.recording.schema_types import message_classes


class Classes:
    """The classes of interfaces in a folder of packages, else of those that ship with rtgen."""

    def __init__(self, share: Path) -> None:
        self._share = share
        self._known: dict[str, Any] = {}

    def of(self, name: str, suffix: str = "") -> Any:
        """Return the class of an interface, or of what it consists of."""
        whole = name + suffix
        if whole not in self._known:
            interface = name.partition("_SendGoal")[0].partition("_GetResult")[0]
            interface = interface.removesuffix("_FeedbackMessage")
            place = f"{interface}.{name.split('/')[1]}"
            file, root = self._share / place, self._share
            if not file.exists():
                file = ros_file(place)
                root = file.parents[2]
            self._known |= message_classes(load([file], root=root).model)
        return self._known[whole]


class OwnPeer(Events):
    """The node."""

    def __init__(self, network: RosNetwork, share: Path) -> None:
        super().__init__()
        self._network = network
        self._classes = Classes(share)
        self._info = message_classes(
            load(
                [ros_file(f"{EVENT_INFO}.msg")],
                root=ros_file(f"{EVENT_INFO}.msg").parents[2],
            ).model
        )[EVENT_INFO]
        self._ends: dict[tuple[str, str], Any] = {}

    def do(self, command: str, *arguments: Any) -> None:
        """Do something: a method of `rclpy_peer.Peer`."""
        getattr(self, f"_{command}")(*arguments)

    def close(self) -> None:
        """Close the network."""
        self._network.close()

    def _end(self, kind: str, name: str, make: Callable[[], Any]) -> Any:
        if (kind, name) not in self._ends:
            self._ends[kind, name] = make()
        return self._ends[kind, name]

    def _service(self, name: str, type_: str) -> RosService:
        request, response = (
            self._classes.of(type_, f"_{end}") for end in ("Request", "Response")
        )
        return RosService(request, response, name, self._info)

    def _message(self, type_: str, value: Any) -> bytes:
        return encoded(value_of(self._classes.of(type_)._descriptor_, value))

    def _subscribe(
        self, topic: str, type_: str, depth: int = 100, late: str | None = None
    ) -> None:
        class_ = self._classes.of(type_)
        name = late or topic
        profile = PROFILES["map" if late else "default"]._replace(depth=depth)
        self._end(
            "reader",
            name,
            lambda: self._network.subscribe(
                RosTopic(topic, class_),
                profile,
                lambda octets: self.tell(
                    "message", name, told(decoded(class_, octets))
                ),
            ),
        )
        self.tell("subscribed", name)

    def _publish(self, topic: str, type_: str, values: list[Any]) -> None:
        publish = self._end(
            "writer",
            topic,
            lambda: self._network.publisher(
                RosTopic(topic, self._classes.of(type_)), PROFILES["default"]
            ),
        )
        for value in values:
            publish(self._message(type_, value))
        self.tell("published", topic)

    def _call(self, name: str, type_: str, request: Any, seconds: float) -> None:
        service = self._service(name, type_)
        call = self._end("client", name, lambda: self._network.client(service))
        octets = encoded(value_of(service.request._descriptor_, request))

        def work() -> None:
            try:
                found = told(decoded(service.reply, call(octets, seconds)))
            except ServiceError:
                found = None
            self.tell("called", name, found)

        threading.Thread(target=work, daemon=True).start()

    def _ask(self, name: str, type_: str, goal: Any, seconds: float) -> None:
        identity = uuid4().bytes
        text = identity.hex()
        kind = self._classes.of(type_, "_FeedbackMessage")

        def feedback(octets: bytes) -> None:
            message = decoded(kind, octets)
            numbers = list(message.feedback.sequence)
            self.tell("feedback", bytes(message.goal_id.uuid).hex(), numbers)

        self._end(
            "feedback",
            name,
            lambda: self._network.subscribe(
                RosTopic(f"{name}/_action/feedback", kind),
                PROFILES["default"],
                feedback,
            ),
        )
        send, end = (
            self._service(f"{name}/_action/{place}", f"{type_}_{part}")
            for place, part in (("send_goal", "SendGoal"), ("get_result", "GetResult"))
        )
        sending, ending, cancelling = (
            self._end("asker", each.name, lambda each=each: self._network.client(each))
            for each in (
                send,
                end,
                self._service(
                    f"{name}/_action/cancel_goal", "action_msgs/srv/CancelGoal"
                ),
            )
        )
        self._ends["goal", text] = cancelling
        request = {"goal_id": {"uuid": identity}, "goal": goal}

        def work() -> None:
            octets = encoded(value_of(send.request._descriptor_, request))
            accepted = decoded(send.reply, sending(octets, seconds)).accepted
            self.tell("asked", name, True, accepted, text)
            if accepted:
                octets = encoded(value_of(end.request._descriptor_, request))
                found = decoded(end.reply, ending(octets, 1000.0))
                self.tell("result", text, found.status, list(found.result.sequence))

        threading.Thread(target=work, daemon=True).start()

    def _cancel(self, goal: str) -> None:
        service = self._service("", "action_msgs/srv/CancelGoal")
        request = {"goal_info": {"goal_id": {"uuid": bytes.fromhex(goal)}}}
        octets = self._ends["goal", goal](
            encoded(value_of(service.request._descriptor_, request)), 20.0
        )
        found = decoded(service.reply, octets)
        self.tell("cancelled", goal, found.return_code, len(found.goals_canceling))
