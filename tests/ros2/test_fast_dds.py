"""Services, actions and managed nodes beside nodes of rclpy on Fast DDS: no request is executed.

Fast DDS has no header before the messages of services, so either side would take it for data.
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from typing import Any
from uuid import uuid4

import media
import pytest
from patience import until
from rclpy_node import Node, node
from ros2_peers import DISTRIBUTIONS, Installation, installation

from rtgen.cli import run as rtgen
from rtgen.runtime import RTC_OK, Component, RealClock, SimulatedClock, System
from rtgen.runtime.ros2.actions import joints_of
from rtgen.runtime.ros2.managed import EVENT_INFO, INTERFACES, ManagedNodes
from rtgen.runtime.ros2.network import RosNode, RosService
from rtgen.runtime.ros2.services import RosServices, ServiceJoint, messages_of
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.running.ros2_classes import message_classes

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = [pytest.mark.peer, pytest.mark.waits]

DOMAIN = media.own_domain()
IDL = """
#include "test_msgs/srv/BasicTypes.idl"
#include "test_msgs/action/Fibonacci.idl"
interface Basics {
    test_msgs::srv::BasicTypes_Response ask(in test_msgs::srv::BasicTypes_Request request);
};
component Counter {
    @port("count") provides test_msgs::action::Fibonacci goals;
    @port("count") uses test_msgs::action::Fibonacci_Events events;
};
component Asker {
    @port("count") uses test_msgs::action::Fibonacci goals;
};
"""
BASICS, FIBONACCI = "test_msgs/srv/BasicTypes", "test_msgs/action/Fibonacci"
SENT = {"int32_value": 7, "float64_value": 1.5, "string_value": "hello"}
WAY_OUT = "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"


@pytest.fixture(
    scope="module",
    params=[
        DISTRIBUTIONS[0],
        *(pytest.param(each, marks=pytest.mark.nightly) for each in DISTRIBUTIONS[1:]),
    ],
)
def ros2(request: pytest.FixtureRequest) -> Installation:
    return installation(request.param)


@pytest.fixture(scope="module")
def peer(ros2: Installation) -> Iterator[Node]:
    with node(ros2, "peer", "/far", domain=DOMAIN) as made:
        yield made


@pytest.fixture(scope="module")
def calls(
    ros2: Installation, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ModuleType]:
    """Import the package generated from interfaces of the installation."""
    folder = tmp_path_factory.mktemp("fast_dds")
    name = f"calls_{ros2.distribution}"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("t.idl").write_text(IDL)
        Path("rtgen.toml").write_text(
            f'[sources]\npaths = ["t.idl"]\ninclude = ["{ros2.share.as_posix()}"]\n'
            f'[output]\npackage = "{name}"\n'
        )
        assert rtgen(["generate", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        package = importlib.import_module(name)
        parts = (
            *("test_msgs.srv", "test_msgs.action", "action_msgs.srv"),
            *("action_msgs.msg", "unique_identifier_msgs.msg"),
            *("components.counter", "components.asker"),
        )
        for part in parts:
            importlib.import_module(f"{name}.{part}")
        yield package


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


@pytest.fixture(scope="module")
def network(peer: Node) -> Iterator[Any]:
    """Return a network that has known the node of rclpy for a while."""
    from rtgen.runtime.ros2.dds import open_dds

    made = open_dds(RosNode("node", "/lab", DOMAIN))
    yield made
    made.close()


@pytest.fixture
def warnings(caplog: pytest.LogCaptureFixture) -> Any:
    """Return a function for the warnings about the other end of services below a name."""

    def found(name: str) -> list[str]:
        return [
            record.getMessage()
            for record in caplog.records
            if record.levelno == logging.WARNING
            and record.getMessage().startswith(name)
        ]

    return found


def basics(calls: ModuleType, name: str) -> RosService:
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    return RosService(*messages_of(calls.Basics, "ask"), name, info)


def consumer_of(stack: ExitStack, network: Any, calls: ModuleType, name: str) -> Any:
    """Return a consumer of the service."""
    component = Component("Asker0")
    consumer = component.add_consumer("asks", "basics", calls.Basics)
    joint = ServiceJoint(consumer, "ask", basics(calls, name))
    stack.callback(RosServices(network, [joint], 20.0).close)
    return consumer


def request_of(calls: ModuleType) -> Any:
    from rtgen.runtime.ros2.types import made

    return made(calls.test_msgs.srv.BasicTypes_Request._descriptor_, SENT)


def provided(stack: ExitStack, network: Any, calls: ModuleType, name: str) -> list[Any]:
    """Serve; return the list of executed requests."""
    executed: list[Any] = []

    class Servant(calls.Basics):  # type: ignore[misc, name-defined]
        def ask(self, request: Any) -> Any:
            executed.append(request)
            members = {m: getattr(request, m) for m in request.__struct_fields__}
            return calls.test_msgs.srv.BasicTypes_Response(**members)

    system = System(SimulatedClock())
    component = Component("Server0")
    component.add_provider("asked", "basics", calls.Basics).set_servant(Servant())
    system.add(component, 100.0)
    assert system.activate("Server0") == RTC_OK
    system.run(20_000_000)
    stack.callback(system.close)
    provider = next(iter(component.providers.values()))
    joint = ServiceJoint(provider, "ask", basics(calls, name))
    stack.callback(RosServices(network, [joint], 20.0).close)
    return executed


def test_a_server_on_fast_dds_is_sent_no_request(
    peer: Node, calls: ModuleType, network: Any, stack: ExitStack, warnings: Any
) -> None:
    name = f"/basics_{uuid4().hex}"
    peer.do("serve", name, BASICS)
    peer.event("serving")
    consumer = consumer_of(stack, network, calls, name)
    for _ in range(3):
        with pytest.raises(ServiceError, match=WAY_OUT) as raised:
            consumer.ask(request_of(calls))
        assert f"{name}: the server in node /far/peer is not called" in str(
            raised.value
        )
    until(lambda: warnings(name))
    assert len(warnings(name)) == 1
    # What the node answers afterwards has come behind anything that it was sent before.
    peer.do("call", name, BASICS, SENT, 20.0)
    [_, response] = peer.event("called")
    assert {key: response[key] for key in SENT} == SENT
    assert peer.event("served")[1]["int32_value"] == 7
    assert not [event for event in peer.events if event[0] == "served"]


def test_a_server_that_speaks_the_form_is_not_called_beside_one_that_does_not(
    peer: Node, calls: ModuleType, network: Any, stack: ExitStack, warnings: Any
) -> None:
    """A request reaches all readers of its topic."""
    name = f"/both_{uuid4().hex}"
    executed = provided(stack, network, calls, name)
    consumer = consumer_of(stack, network, calls, name)
    assert consumer.ask(request_of(calls)).string_value == "hello"
    peer.do("serve", name, BASICS)
    peer.event("serving")

    def refused() -> bool:
        try:
            consumer.ask(request_of(calls))
        except ServiceError as error:
            return "/far/peer" in str(error)
        return False

    until(refused)
    number = len(executed)
    # Its answer comes behind anything that it was sent before.
    peer.do("call", name, BASICS, SENT, 20.0)
    assert peer.event("called")[1]["int32_value"] == 7
    assert peer.event("served")[1]["int32_value"] == 7
    assert not [event for event in peer.events if event[0] == "served"]
    assert len(executed) == number


@pytest.mark.parametrize("text", ["", "hello", "hello" * 20])
def test_a_client_on_fast_dds_executes_nothing(
    text: str,
    peer: Node,
    calls: ModuleType,
    network: Any,
    stack: ExitStack,
    warnings: Any,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """A long text makes the request as long as one with a header; Cyclone refuses short ones."""
    name = f"/basics_{uuid4().hex}"
    executed = provided(stack, network, calls, name)
    for _ in range(2):
        peer.do("call", name, BASICS, {**SENT, "string_value": text}, 0.5)
        assert peer.event("called") == [name, None]
    until(lambda: warnings(name))
    [warning] = warnings(name)
    assert "the client in node /far/peer gets no response" in warning
    assert WAY_OUT in warning
    assert "deserialization" not in capfd.readouterr().err
    # One that speaks the form is served beside it.
    consumer = consumer_of(stack, network, calls, name)
    assert consumer.ask(request_of(calls)).int32_value == 7
    assert [request.int32_value for request in executed] == [7]


def test_actions(
    peer: Node, calls: ModuleType, network: Any, stack: ExitStack, warnings: Any
) -> None:
    """Both sides of an action: three services each, one warning for each side."""
    system = stack.enter_context(System(RealClock()))
    counter = calls.components.counter.CounterBase("counter0")
    asker = calls.components.asker.AskerBase("asker0")
    executed: list[Any] = []

    class Goals(calls.test_msgs.action.Fibonacci):  # type: ignore[misc, name-defined]
        def send_goal(self, request: Any) -> Any:
            executed.append(request)
            return calls.test_msgs.action.Fibonacci_SendGoal_Response(True)

        def cancel_goal(self, request: Any) -> Any:
            executed.append(request)
            return calls.action_msgs.srv.CancelGoal_Response()

        def get_result(self, request: Any) -> Any:
            executed.append(request)
            return calls.test_msgs.action.Fibonacci_GetResult_Response()

    counter.goals.set_servant(Goals())
    for each in (counter, asker):
        system.add(each, 100.0)
        assert system.activate(each.instance_name) == RTC_OK
    until(lambda: system.run(system.time + 10_000_000) or counter.is_active)
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    own, other = (f"/{word}_{uuid4().hex}" for word in ("own", "other"))
    joints = [
        *joints_of(counter, "count", own, info),
        *joints_of(asker, "count", other, info),
    ]
    stack.callback(RosServices(network, joints, 20.0).close)
    peer.do("ask", own, FIBONACCI, {"order": 3}, 0.5)
    assert peer.event("asked")[2] is None
    peer.do("act", other, FIBONACCI)
    peer.event("acting")
    uuid = calls.unique_identifier_msgs.msg.UUID(bytes(range(16)))
    goal = calls.test_msgs.action.Fibonacci_Goal(3)
    request = calls.test_msgs.action.Fibonacci_SendGoal_Request(uuid, goal)
    with pytest.raises(
        ServiceError, match=f"{other}/_action/send_goal: the server in "
    ):
        asker.goals.send_goal(request)
    with pytest.raises(ServiceError, match=WAY_OUT):
        asker.goals.get_result(calls.test_msgs.action.Fibonacci_GetResult_Request(uuid))
    until(lambda: warnings(own) and warnings(other))
    assert len(warnings(own)) == len(warnings(other)) == 1
    assert not executed
    assert not [event for event in peer.events if event[0] == "goal"]


def test_managed_nodes(
    peer: Node, network: Any, stack: ExitStack, warnings: Any
) -> None:
    """Neither their life cycle nor their parameters are changed; their topics are read."""
    system = stack.enter_context(System(RealClock()))
    component = Component(f"m{uuid4().hex}")
    system.add(component, 100.0)
    name = component.instance_name
    classes = message_classes(*INTERFACES)
    nodes = ManagedNodes(network, system, {name: name}, classes, "/lab")
    stack.callback(nodes.close)
    place = f"/lab/{name}"
    change = f"{place}/change_state", "lifecycle_msgs/srv/ChangeState"
    peer.do(
        "subscribe", f"{place}/transition_event", "lifecycle_msgs/msg/TransitionEvent"
    )
    peer.event("subscribed")
    peer.do("wait", *change, 20.0)
    assert peer.event("waited")[1]
    peer.do("call", *change, {"transition": {"id": 3}}, 0.5)
    assert peer.event("called")[1] is None
    parameters = f"{place}/list_parameters", "rcl_interfaces/srv/ListParameters"
    peer.do("call", *parameters, {"depth": 5}, 0.5)
    assert peer.event("called")[1] is None
    until(lambda: warnings(change[0]) and warnings(parameters[0]))
    assert len(warnings(place)) == 2
    assert not component.is_active
    assert system.activate(name) == RTC_OK

    def told() -> bool:
        system.run(system.time + 10_000_000)
        return any(event[0] == "message" for event in peer.events)

    until(told)
    assert peer.event("message")[1]["goal_state"]["label"] == "active"
