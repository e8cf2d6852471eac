"""One system on each network of ROS 2, beside nodes of rclpy, or of the same network.

The system runs as users run it, `rtgen run --ros2 NETWORK`; over rclpy in the installation.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import media
import pytest
from free_ports import free_port
from own_peer import Classes, OwnPeer
from patience import PATIENCE, until
from random_values import Values, told
from rclpy_node import Events, node
from ros2_peers import Installation, installation
from seeds import seed
from subject import LAST, OTHERS, SPACE, create, port_of, running, shipped

from rtgen.runtime.ros2.network import RosNode
from rtgen.runtime.ros2.types import type_hash

pytestmark = [pytest.mark.peer, pytest.mark.waits, pytest.mark.nightly]

BASICS, FIBONACCI = "test_msgs/srv/BasicTypes", "test_msgs/action/Fibonacci"
STRING = "std_msgs/msg/String"
LIMIT = 60.0
SUCCEEDED, CANCELED = 4, 5
NUMBERS = [0, 1, 1, 2, 3, 5, 8, 13]
VALUES = {
    "bool_value": True,
    "byte_value": 255,
    "char_value": 7,
    "float32_value": 0.5,
    "float64_value": pi,
    "int8_value": -128,
    "uint8_value": 255,
    "int16_value": -32768,
    "uint16_value": 65535,
    "int32_value": -(2**31),
    "uint32_value": 2**32 - 1,
    "int64_value": -(2**63),
    "uint64_value": 2**64 - 1,
    "string_value": "é表😀" * 20,
}


class Beside(NamedTuple):
    """A network of the system, and the distribution of the nodes beside it; None for its own."""

    network: str
    distribution: str | None

    def __str__(self) -> str:
        return f"{self.network}-{self.distribution or 'own'}"


class Lab(NamedTuple):
    """The system and a node beside it."""

    beside: Beside
    peer: Any
    types: list[str]
    classes: Classes

    def do(self, task: str, *arguments: Any) -> None:
        """Give `Asker0` a task."""
        text = json.dumps([task, *arguments])
        self.peer.do("publish", f"{SPACE}/task", STRING, [{"data": text}])
        self.peer.event("published")

    def told(self, *start: Any) -> list[Any]:
        """Wait for what it tells, by how that begins; the rest stays."""

        def found() -> Any:
            for event in list(self.peer.events):
                if event[:2] == ["message", f"{SPACE}/told"]:
                    words = json.loads(event[2]["data"])
                    if words[: len(start)] == list(start):
                        self.peer.events.remove(event)
                        return words
            return None

        words: list[Any] = until(found, shown=lambda: f"{start}: {self.peer.events}")
        return words[1:]


EVERY = [
    Beside("rclpy", "jazzy"),
    Beside("rclpy", "kilted"),
    Beside("dds", None),
    Beside("zenoh", None),
]
"""Networks beside nodes with which all works."""
TOPICS_ALONE = [
    Beside("dds", "jazzy"),
    Beside("dds", "kilted"),
]
"""Nodes on Fast DDS have other messages of services than Cyclone DDS can send."""


@pytest.fixture(scope="module")
def lab(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Lab]:
    """Run the system with a node beside it."""
    beside: Beside = request.param
    share = installation("jazzy").share
    ros2 = installation(beside.distribution or "jazzy")
    folder = tmp_path_factory.mktemp(str(beside))
    domain = media.own_domain()
    with _peer(beside, ros2, domain, folder) as (peer, more):
        types = [
            name for name in shipped(share) if (ros2.share / f"{name}.msg").exists()
        ]
        others = OTHERS if beside.distribution else SPACE
        create(folder, share, types, more, others)
        command = [sys.executable, "-m", "rtgen"]
        if beside.network == "rclpy":
            command = [ros2.rtgen]
        environment = ros2.environment(domain)
        with running(command, beside.network, folder, environment):
            yield Lab(beside, peer, types, Classes(share))


@contextmanager
def _peer(
    beside: Beside, ros2: Installation, domain: int, folder: Path
) -> Iterator[tuple[Events, str]]:
    """Yield a node, and the settings by which the system finds it."""
    if beside.distribution is not None:
        with node(ros2, "peer", OTHERS, domain=domain) as found:
            yield found, ""
        return
    own = RosNode("peer", OTHERS, domain)
    more = ""
    if beside.network == "dds":
        pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
        from rtgen.runtime.ros2.dds import open_dds

        network = open_dds(own)
    else:
        pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
        from rtgen.runtime.ros2.zenoh import configuration, open_zenoh

        place = f"tcp/127.0.0.1:{free_port()}"
        network = open_zenoh(own, config=configuration(connect=None, listen=place))
        more = 'zenoh = "zenoh.json5"'
        settings = {
            "mode": "peer",
            "connect": {"endpoints": [place]},
            "listen": {"endpoints": ["tcp/127.0.0.1:0"]},
            "scouting": {"multicast": {"enabled": False}},
            "timestamping": {"enabled": True},
        }
        (folder / "zenoh.json5").write_text(json.dumps(settings))
    made = OwnPeer(network, ros2.share)
    try:
        yield made, more
    finally:
        made.close()


everywhere = pytest.mark.parametrize("lab", EVERY, indirect=True, ids=str)


@pytest.mark.parametrize("lab", [*EVERY, *TOPICS_ALONE], indirect=True, ids=str)
def test_every_message_both_ways(lab: Lab) -> None:
    """Random values of all types come back with all fields."""
    assert len(lab.types) > 120
    values = Values(random.Random(seed()))
    sent = {
        name: told(values.of(lab.classes.of(name)._descriptor_)) for name in lab.types
    }
    left = {f"{SPACE}/out/{port_of(name)}": name for name in lab.types}
    for topic, name in left.items():
        lab.peer.do("subscribe", topic, name)
        lab.peer.event("subscribed")

    def returned() -> bool:
        """Send what has not come back: readers may not be known yet."""
        for name in left.values():
            place = f"{SPACE}/in/{port_of(name)}"
            lab.peer.do("publish", place, name, [sent[name]])
            lab.peer.event("published")
        time.sleep(0.3)
        for event in [event for event in lab.peer.events if event[0] == "message"]:
            lab.peer.events.remove(event)
            if event[1] in left:
                name = left.pop(event[1])
                assert event[2] == sent[name], name
        return not left

    until(returned, shown=lambda: sorted(left))


@pytest.mark.parametrize("lab", [*EVERY, *TOPICS_ALONE], indirect=True, ids=str)
def test_late_nodes_get_the_last_message(lab: Lab) -> None:
    """Of a topic with the profile `map`: it keeps one message."""
    there, back = f"{SPACE}/in/{port_of(LAST)}", f"{SPACE}/out/{port_of(LAST)}"
    lab.peer.do("subscribe", back, LAST)
    lab.peer.event("subscribed")

    def known() -> bool:
        lab.peer.do("publish", there, LAST, [{"data": 200}])
        time.sleep(0.1)
        return ["message", back, {"data": 200}] in lab.peer.events

    until(known)
    for number in range(20):
        lab.peer.do("publish", there, LAST, [{"data": number}])
        assert lab.peer.event("message", back, {"data": number})
    lab.peer.do("subscribe", back, LAST, 1, "late")
    assert lab.peer.event("message", "late")[1] == {"data": 19}


@everywhere
def test_the_system_serves(lab: Lab) -> None:
    """Five calls at once, with all fields."""
    for number in range(5):
        values = {**VALUES, "int32_value": number}
        lab.peer.do("call", f"{SPACE}/basics", BASICS, values, LIMIT)
        [_, response] = lab.peer.event("called")
        assert response == values


@everywhere
def test_the_system_calls(lab: Lab) -> None:
    if lab.beside.distribution is not None:
        lab.peer.do("serve", f"{OTHERS}/basics", BASICS)
        lab.peer.event("serving")
    listening(lab)
    for number in range(5):
        lab.do("call", {**VALUES, "int32_value": number})
    results = [lab.told("call")[0] for _ in range(5)]
    assert sorted(result["int32_value"] for result in results) == [*range(5)]
    assert all(
        {**result, "int32_value": 0} == {**VALUES, "int32_value": 0}
        for result in results
    )


def listening(lab: Lab) -> None:
    """Wait until `Asker0` gets tasks, and the peer what it tells."""
    lab.peer.do("subscribe", f"{SPACE}/told", STRING)
    lab.peer.event("subscribed")
    numbers = count()

    def heard() -> bool:
        lab.do("echo", next(numbers))
        time.sleep(0.1)
        return any(
            event[:2] == ["message", f"{SPACE}/told"] for event in lab.peer.events
        )

    until(heard)


@everywhere
def test_an_action_of_the_system(lab: Lab) -> None:
    """Five goals at once with feedback, a rejected one, and one that is cancelled."""
    action = f"{SPACE}/count", FIBONACCI

    def asked(order: int) -> str:
        lab.peer.do("ask", *action, {"order": order}, LIMIT)
        _, known, accepted, goal = lab.peer.event("asked")
        assert (known, accepted) == (True, order > 0)
        return str(goal)

    def shown() -> bool:
        """Whether feedback comes: the server may be known before the topic's other end."""
        asked(2)
        time.sleep(0.1)
        return any(event[0] == "feedback" for event in lab.peer.events)

    # Of a goal that ends, rclpy does not tell what has come before its result.
    until(shown)
    goals = {asked(order): order for order in (2, 3, 4, 5, 6)}
    for goal, order in goals.items():
        for length in range(3, order + 2):
            assert lab.peer.event("feedback", goal)[1] == NUMBERS[:length]
    asked(0)
    cancelled, *others = goals
    lab.peer.do("cancel", cancelled)
    assert lab.peer.event("cancelled", cancelled)[1:] == [0, 1]
    assert lab.peer.event("result", cancelled)[1:] == [CANCELED, NUMBERS[:3]]
    finish(lab, True)
    for goal in others:
        numbers = NUMBERS[: goals[goal] + 1]
        assert lab.peer.event("result", goal)[1:] == [SUCCEEDED, numbers]
    states = f"{action[0]}/_action/status", "action_msgs/msg/GoalStatusArray"

    def all_ended() -> bool:
        lab.peer.do("subscribe", *states, 1, "states")
        [_, message] = lab.peer.event("message", "states")
        ends = {
            bytes(each["goal_info"]["goal_id"]["uuid"]).hex(): each["status"]
            for each in message["status_list"]
        }
        return [ends[goal] for goal in goals] == [CANCELED, *[SUCCEEDED] * 4]

    # A result can come before the last status.
    until(all_ended)


def finish(lab: Lab, own: bool) -> None:
    """Let the goals of the system's action, or of the peer's, succeed."""
    if own or lab.beside.distribution is None:
        request = {"string_value": "finish"}
        lab.peer.do("call", f"{SPACE}/basics", BASICS, request, LIMIT)
        lab.peer.event("called", f"{SPACE}/basics")
    else:
        lab.peer.do("finish", True)


@everywhere
def test_the_system_has_goals(lab: Lab) -> None:
    """The same with the action of a node."""
    if lab.beside.distribution is not None:
        lab.peer.do("act", f"{OTHERS}/count", FIBONACCI)
        lab.peer.event("acting")
    listening(lab)

    def asked(order: int) -> str:
        lab.do("goal", order)
        goal, accepted = lab.told("accepted")
        assert accepted == (order > 0)
        return str(goal)

    def shown() -> bool:
        asked(2)
        time.sleep(0.1)
        return any('"feedback"' in str(event[2:]) for event in lab.peer.events)

    until(shown)
    goals = {asked(order): order for order in (2, 3, 4, 5, 6)}
    for goal, order in goals.items():
        for length in range(3, order + 2):
            assert lab.told("feedback", goal)[1] == NUMBERS[:length]
    rejected = asked(0)
    assert lab.told("goal", rejected)[1:] == [None, None]
    cancelled, *others = goals
    lab.do("cancel", cancelled)
    assert lab.told("cancel", cancelled)[1:] == [0, 1]
    assert lab.told("goal", cancelled)[1:] == [CANCELED, NUMBERS[:3]]
    assert lab.told("status", cancelled, CANCELED)
    finish(lab, False)
    for goal in others:
        numbers = NUMBERS[: goals[goal] + 1]
        assert lab.told("goal", goal)[1:] == [SUCCEEDED, numbers]
        assert lab.told("status", goal, SUCCEEDED)


@everywhere
def test_the_life_cycle(lab: Lab) -> None:
    """States, transitions and their events."""
    place = f"{SPACE}/Relay0"
    event = "lifecycle_msgs/msg/TransitionEvent"
    lab.peer.do("subscribe", f"{place}/transition_event", event)
    lab.peer.event("subscribed")

    def call(name: str, type_: str, request: Any) -> Any:
        lab.peer.do(
            "call", f"{place}/{name}", f"lifecycle_msgs/srv/{type_}", request, LIMIT
        )
        return lab.peer.event("called")[1]

    assert call("get_state", "GetState", {})["current_state"]["label"] == "active"
    states = call("get_available_states", "GetAvailableStates", {})["available_states"]
    assert [state["label"] for state in states][:2] == ["inactive", "active"]

    def changed() -> bool:
        return any(
            each[:2] == ["message", f"{place}/transition_event"]
            for each in lab.peer.events
        )

    def cycled() -> bool:
        for number, label in ((4, "inactive"), (3, "active")):
            assert call("change_state", "ChangeState", {"transition": {"id": number}})[
                "success"
            ]
            found = call("get_state", "GetState", {})
            assert found["current_state"]["label"] == label
        time.sleep(0.1)
        return changed()

    until(cycled)
    found = lab.peer.event("message", f"{place}/transition_event")[1]
    assert found["goal_state"]["label"] in ("inactive", "active")
    assert not call("change_state", "ChangeState", {"transition": {"id": 1}})["success"]


@everywhere
def test_parameters(lab: Lab) -> None:
    """Listed, set, refused, read and described; by rclpy's own client, too."""
    place = f"{SPACE}/Counter0"

    def call(name: str, type_: str, request: Any) -> Any:
        lab.peer.do(
            "call", f"{place}/{name}", f"rcl_interfaces/srv/{type_}", request, LIMIT
        )
        return lab.peer.event("called")[1]

    names = call("list_parameters", "ListParameters", {})["result"]["names"]
    assert names == ["size", "number", "word", "flag", "configuration.active_config"]
    size, far = (
        {"name": "size", "value": {"type": 3, "double_value": x}} for x in (1.5, 9.0)
    )
    results = call("set_parameters", "SetParameters", {"parameters": [size, far]})[
        "results"
    ]
    assert [result["successful"] for result in results] == [True, False]
    assert "at most 3" in results[1]["reason"]
    together = call(
        "set_parameters_atomically",
        "SetParametersAtomically",
        {"parameters": [size, far]},
    )
    assert not together["result"]["successful"]
    [value, other] = call(
        "get_parameters", "GetParameters", {"names": ["size", "none"]}
    )["values"]
    assert (value["double_value"], other["type"]) == (1.5, 0)
    assert call("get_parameter_types", "GetParameterTypes", {"names": names[:4]})[
        "types"
    ] == [3, 2, 4, 1]
    [found] = call("describe_parameters", "DescribeParameters", {"names": ["size"]})[
        "descriptors"
    ]
    assert found["floating_point_range"][0]["to_value"] == 3.0
    lab.peer.do("subscribe", "/parameter_events", "rcl_interfaces/msg/ParameterEvent")

    def told() -> bool:
        """Set one until its event comes: the topic may not be known yet."""
        number = {"name": "number", "value": {"type": 2, "integer_value": 9}}
        call("set_parameters", "SetParameters", {"parameters": [number]})
        time.sleep(0.1)
        return any(
            event[:2] == ["message", "/parameter_events"]
            and event[2]["node"] == place
            and event[2]["changed_parameters"][0]["value"]["integer_value"] == 9
            for event in lab.peer.events
        )

    until(told)
    if lab.beside.distribution is not None:
        lab.peer.do("parameters", place, {"size": 2.5, "word": "b", "number": 3}, LIMIT)
        known, listed, changed, found, described = lab.peer.event("parameters")[1:]
        assert known
        assert listed["result"]["names"] == names
        assert [each["successful"] for each in changed["results"]] == [True] * 3
        values = found["values"]
        assert values[0]["double_value"] == 2.5
        assert (values[1]["string_value"], values[2]["integer_value"]) == ("b", 3)
        assert described["descriptors"][0]["name"] == "size"


@pytest.mark.parametrize("lab", [*EVERY[:2], *TOPICS_ALONE], indirect=True, ids=str)
def test_nodes(lab: Lab) -> None:
    """The network's own, and one for each component."""

    def seen() -> bool:
        lab.peer.do("nodes")
        names = lab.peer.event("nodes")[0]
        wanted = ("subject", "Relay0", "Counter0", "Asker0")
        return {f"{SPACE}/{name}" for name in wanted} <= set(names)

    until(seen)


@pytest.mark.parametrize("lab", [*EVERY, *TOPICS_ALONE], indirect=True, ids=str)
def test_lines_of_logs_are_kept_for_late_nodes(lab: Lab) -> None:
    """For ten seconds."""
    listening(lab)
    lab.do("log", "it is late")
    lab.told("log")
    lab.peer.do("subscribe", "/rosout", "rcl_interfaces/msg/Log", 100, "rosout")
    line = until(
        lambda: next(
            (
                event[2]
                for event in lab.peer.events
                if event[:2] == ["message", "rosout"]
                and event[2]["msg"] == "it is late"
            ),
            None,
        )
    )
    assert line["level"] == 30


@everywhere
def test_types_are_described(lab: Lab) -> None:
    name = "std_msgs/msg/String"
    request = {
        "type_name": name,
        "type_hash": type_hash(lab.classes.of(name)),
        "include_type_sources": True,
    }
    service = f"{SPACE}/Asker0/get_type_description"
    type_ = "type_description_interfaces/srv/GetTypeDescription"
    lab.peer.do("call", service, type_, request, LIMIT)
    response = lab.peer.event("called", service)[1]
    assert response["successful"], response["failure_reason"]
    described = response["type_description"]["type_description"]
    assert described["type_name"] == name
    assert [field["name"] for field in described["fields"]] == ["data"]


CALLS = Path(__file__).with_name("network_calls.py")


@pytest.mark.parametrize(
    "beside",
    [
        Beside("rclpy", "jazzy"),
        Beside("rclpy", "kilted"),
        Beside("dds", None),
        Beside("zenoh", None),
    ],
    ids=str,
)
def test_calls_that_fail(beside: Beside) -> None:
    environment = {**os.environ, "ROS_DOMAIN_ID": str(media.own_domain())}
    python = sys.executable
    if beside.distribution is not None:
        ros2 = installation(beside.distribution)
        python, environment = ros2.python, ros2.environment(media.own_domain())
    else:
        library = {"dds": "cyclonedds", "zenoh": "zenoh"}[beside.network]
        pytest.importorskip(library, reason=f"{library} is not installed")
    done = subprocess.run(
        [python, str(CALLS), beside.network, str(free_port())],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=PATIENCE,
    )
    assert json.loads(done.stdout) == {
        "nobody serves": "ObjectNotExist",
        "no response": "CallTimeout",
        "late": "CallTimeout",
        "after a late one": "in time",
        "in another order": ["0", "1", "2", "3", "4"],
        "the run ends": "CallEnded",
        "the server is lost": "CommunicationFailure",
    }
