"""Service ports as actions, with clients and servers of cyclonedds alone.

The other side uses what ROS 2 puts on the wire for `lab/action/Go`: three services and two topics
with their types.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack
from types import ModuleType
from typing import Any
from uuid import uuid4

import pytest
from action_ends import (
    CANCELED,
    EXECUTING,
    SUCCEEDED,
    component,
    generated,
    joined,
    servant,
)
from patience import until
from test_managed_nodes import HEAD, Time, sequence, type_
from test_networks import DOMAIN, participant, reliable

from rtgen.runtime.ros2.actions import joints_of
from rtgen.runtime.ros2.managed import EVENT_INFO
from rtgen.runtime.ros2.network import RosNode
from rtgen.runtime.services.servants import CommunicationFailure, ServiceError
from rtgen.tools.running.ros2_classes import message_classes

cyclonedds = pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from cyclonedds.idl.types import array as array_  # noqa: E402
from cyclonedds.idl.types import float64, int8, uint8  # noqa: E402

array: Any = array_
UUID = type_("unique_identifier_msgs/msg/UUID", {"uuid": array[uint8, 16]})
Goal = type_("lab/action/Go_Goal", {"x": float64})
Outcome = type_("lab/action/Go_Result", {"done": bool})
Left = type_("lab/action/Go_Feedback", {"left": float64})
FeedbackMessage = type_(
    "lab/action/Go_FeedbackMessage", {"goal_id": UUID, "feedback": Left}
)
GoalInfo = type_("action_msgs/msg/GoalInfo", {"goal_id": UUID, "stamp": Time})
GoalStatus = type_(
    "action_msgs/msg/GoalStatus", {"goal_info": GoalInfo, "status": int8}
)
GoalStatusArray = type_(
    "action_msgs/msg/GoalStatusArray", {"status_list": sequence[GoalStatus]}
)
SERVICES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "send_goal": (
        "lab/action/Go_SendGoal",
        {"goal_id": UUID, "goal": Goal},
        {"accepted": bool, "stamp": Time},
    ),
    "cancel_goal": (
        "action_msgs/srv/CancelGoal",
        {"goal_info": GoalInfo},
        {"return_code": int8, "goals_canceling": sequence[GoalInfo]},
    ),
    "get_result": (
        "lab/action/Go_GetResult",
        {"goal_id": UUID},
        {"status": int8, "result": Outcome},
    ),
}
ONE = list(range(16))


@pytest.fixture(scope="module")
def go(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    return generated(tmp_path_factory.mktemp("actions"))


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def dds_network() -> Any:
    from rtgen.runtime.ros2.dds import open_dds

    return open_dds(RosNode("node", "/lab", DOMAIN))


class Peer:
    """Ends of an action written with cyclonedds alone."""

    def __init__(self, action: str) -> None:
        self.part = participant()
        self.action = action

    def topic(self, name: str, type_of: Any) -> Any:
        from cyclonedds.topic import Topic

        return Topic(self.part, name, type_of)

    def service(self, name: str) -> tuple[Any, Any, Any, Any]:
        """Return the topics of a service with their types."""
        type_name, request, reply = SERVICES[name]
        types = (
            type_(f"{type_name}_Request", HEAD | request),
            type_(f"{type_name}_Response", HEAD | reply),
        )
        place = f"{self.action}/_action/{name}"
        return (
            self.topic(f"rq{place}Request", types[0]),
            self.topic(f"rr{place}Reply", types[1]),
            *types,
        )

    def requests(self, name: str) -> Any:
        """Return a client of a service: a function that sends, and returns one for the reply."""
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader

        one, other, request, _ = self.service(name)
        writer = DataWriter(self.part, one, reliable("clientid"))
        reader = DataReader(self.part, other, reliable("clientid"))
        until(writer.get_matched_subscriptions)
        until(reader.get_matched_publications)

        def send(**members: Any) -> Any:
            writer.write(request(rmw_client=7, rmw_sequence=1, **members))
            return lambda: reader.take(8)

        return send

    def reader(self, name: str, type_of: Any, *, late: bool = False) -> Any:
        from cyclonedds.qos import Policy, Qos
        from cyclonedds.sub import DataReader

        more = (Policy.Durability.TransientLocal,) if late else ()
        qos = Qos(Policy.History.KeepAll, *more, base=reliable())
        topic = self.topic(f"rt{self.action}/_action/{name}", type_of)
        reader = DataReader(self.part, topic, qos)
        until(reader.get_matched_publications)
        return reader


def taken(reader: Any, number: int) -> list[Any]:
    found: list[Any] = []
    until(lambda: len(found) >= number or found.extend(reader.take(8)))  # type: ignore[func-returns-value]
    return found


def test_a_client_of_cyclonedds(go: ModuleType, stack: ExitStack) -> None:
    """It sends a goal, reads feedback and status, waits for the result beside other requests."""
    mover = component(stack, go, "mover")
    goals = servant(go, mover.events)
    mover.goals.set_servant(goals)
    name = f"/go_{uuid4().hex}"
    joined(stack, dds_network(), mover, name)
    peer = Peer(name)
    feedback = peer.reader("feedback", FeedbackMessage)
    send_goal, cancel, get_result = map(peer.requests, SERVICES)
    [accepted] = until(send_goal(goal_id=UUID(ONE), goal=Goal(3.0)))
    assert accepted.accepted
    found = taken(feedback, 2)
    assert [message.feedback.left for message in found] == [6.0, 3.0]
    assert list(found[0].goal_id.uuid) == ONE
    # A late reader gets the last status, as by rcl_action's profile.
    status = peer.reader("status", GoalStatusArray, late=True)
    [[last]] = [message.status_list for message in taken(status, 1)]
    assert (list(last.goal_info.goal_id.uuid), last.status) == (ONE, EXECUTING)
    result = get_result(goal_id=UUID(ONE))
    info = GoalInfo(UUID(ONE), Time(0, 0))
    [cancelled] = until(cancel(goal_info=info))
    assert list(cancelled.goals_canceling[0].goal_id.uuid) == ONE
    [ended] = until(result)
    assert (ended.status, ended.result.done) == (CANCELED, False)
    result = get_result(goal_id=UUID(ONE))
    assert until(result)[0].status == CANCELED


class Server:
    """An action server of cyclonedds alone: sends feedback for a goal, and its result at once."""

    def __init__(self, peer: Peer) -> None:
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader

        self.ends = {}
        for name in SERVICES:
            one, other, _, reply = peer.service(name)
            reader = DataReader(peer.part, one, reliable("serviceid"))
            writer = DataWriter(peer.part, other, reliable("serviceid"))
            self.ends[name] = reader, writer, reply
        topic = peer.topic(f"rt{peer.action}/_action/feedback", FeedbackMessage)
        self.feedback = DataWriter(peer.part, topic, reliable())

    def answer(self, name: str, **members: Any) -> Any:
        """Take a request, reply to it, and return it."""
        reader, writer, reply = self.ends[name]
        [request] = until(lambda: reader.take(8))
        client, sequence_ = request.rmw_client, request.rmw_sequence
        writer.write(reply(rmw_client=client, rmw_sequence=sequence_, **members))
        return request

    def close(self) -> None:
        for reader, writer, _ in self.ends.values():
            for each in (reader, writer):
                each.__del__()
        self.ends.clear()


def test_a_server_of_cyclonedds(go: ModuleType, stack: ExitStack) -> None:
    """A component sends a goal, gets feedback in order, and the result."""
    asker = component(stack, go, "asker")
    action = go.lab.action
    came: list[float] = []

    class Events(action.Go_Events):  # type: ignore[misc, name-defined]
        def feedback(self, message: Any) -> None:
            came.append(message.feedback.left)

        def status(self, message: Any) -> None:
            raise AssertionError

    asker.events.set_servant(Events())
    name = f"/go_{uuid4().hex}"
    joined(stack, dds_network(), asker, name)
    server = Server(Peer(name))
    until(server.feedback.get_matched_subscriptions)
    uuid = go.unique_identifier_msgs.msg.UUID(bytes(ONE))
    done: list[Any] = []

    def ask() -> None:
        request = action.Go_SendGoal_Request(uuid, action.Go_Goal(2.0))
        done.append(asker.goals.send_goal(request).accepted)
        result = asker.goals.get_result(action.Go_GetResult_Request(uuid))
        done.append((result.status, result.result.done))
        try:
            asker.goals.get_result(action.Go_GetResult_Request(uuid))
        except CommunicationFailure as error:
            done.append(str(error))

    thread = threading.Thread(target=ask)
    thread.start()
    goal = server.answer("send_goal", accepted=True, stamp=Time(0, 0))
    assert (list(goal.goal_id.uuid), goal.goal.x) == (ONE, 2.0)
    for number in range(20):
        server.feedback.write(FeedbackMessage(UUID(ONE), Left(float(number))))
        until(lambda: len(came) > number)  # noqa: B023
    server.answer("get_result", status=SUCCEEDED, result=Outcome(True))
    # The server disappears while a call waits, which nothing else would end.
    until(lambda: server.ends["get_result"][0].take(8))
    server.close()
    thread.join()
    assert done == [
        True,
        (SUCCEEDED, True),
        f"{name}/_action/get_result is served no more",
    ]
    assert came == [float(number) for number in range(20)]


@pytest.mark.parametrize(
    ("name", "port", "why"),
    [
        ("mover", "way", "mover0 has no service port 'way'; known: go, alone"),
        ("mover", "alone", "mover0.alone provides lab::action::Go, but does not use "),
        ("asker", "other", "asker0.other has no interface of an action: lab::action::"),
        ("asker", "both", "asker0.both uses both lab::action::Go and lab::action::Go_"),
    ],
)
def test_other_ports_are_refused(
    go: ModuleType, stack: ExitStack, name: str, port: str, why: str
) -> None:
    made = component(stack, go, name)
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    with pytest.raises(ServiceError, match=why):
        list(joints_of(made, port, "/go", info))
