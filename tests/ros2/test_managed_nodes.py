"""Components as managed nodes, with peers of cyclonedds and Zenoh that use only ROS's names.

The peer's types are written by hand like those of ROS 2, and encoded by cyclonedds for both
networks.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar

import pytest
from patience import until
from test_networks import DOMAIN, participant, reliable, zenoh_pair

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime import (
    RTC_ERROR,
    RTC_OK,
    Component,
    ComponentProfile,
    RealClock,
    ReturnCode_t,
    System,
)
from rtgen.runtime.ros2.life_cycle import STATES, TRANSITIONS
from rtgen.runtime.ros2.managed import INTERFACES, ManagedNodes
from rtgen.runtime.ros2.network import RosNode
from rtgen.runtime.ros2.parameters import Kind, Parameters
from rtgen.runtime.rtc.configuration import ConfigurationSets
from rtgen.runtime.rtc.profiles import ParameterProfile
from rtgen.runtime.services.servants import ServiceError
from rtgen.tools.running.ros2_classes import message_classes

cyclonedds = pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")
zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

from cyclonedds.idl import make_idl_struct  # noqa: E402
from cyclonedds.idl.types import (  # noqa: E402
    byte,
    float64,
    int32,
    int64,
    uint8,
    uint32,
    uint64,
)
from cyclonedds.idl.types import sequence as sequence_  # noqa: E402

sequence: Any = sequence_

STATE = {"id": uint8, "label": str}
EMPTY = {"structure_needs_at_least_one_member": uint8}


def type_(name: str, members: dict[str, Any]) -> Any:
    """Return a type of cyclonedds with the name that rosidl gives it."""
    scope, _, last = name.rpartition("/")
    full = f"{scope.replace('/', '::')}::dds_::{last}_"
    made = make_idl_struct(full.replace("::", "_"), full, members)
    made.__idl_annotations__["extensibility"] = "final"
    return made


State = type_("lifecycle_msgs/msg/State", STATE)
Transition = type_("lifecycle_msgs/msg/Transition", STATE)
Description = type_(
    "lifecycle_msgs/msg/TransitionDescription",
    {"transition": Transition, "start_state": State, "goal_state": State},
)
TransitionEvent = type_(
    "lifecycle_msgs/msg/TransitionEvent",
    {
        "timestamp": uint64,
        "transition": Transition,
        "start_state": State,
        "goal_state": State,
    },
)
Value = type_(
    "rcl_interfaces/msg/ParameterValue",
    {
        "type": uint8,
        "bool_value": bool,
        "integer_value": int64,
        "double_value": float64,
        "string_value": str,
        "byte_array_value": sequence[byte],
        "bool_array_value": sequence[bool],
        "integer_array_value": sequence[int64],
        "double_array_value": sequence[float64],
        "string_array_value": sequence[str],
    },
)
Parameter = type_("rcl_interfaces/msg/Parameter", {"name": str, "value": Value})
Time = type_("builtin_interfaces/msg/Time", {"sec": int32, "nanosec": uint32})
ParameterEvent = type_(
    "rcl_interfaces/msg/ParameterEvent",
    {
        "stamp": Time,
        "node": str,
        "new_parameters": sequence[Parameter],
        "changed_parameters": sequence[Parameter],
        "deleted_parameters": sequence[Parameter],
    },
)
Result = type_(
    "rcl_interfaces/msg/SetParametersResult", {"successful": bool, "reason": str}
)
Listed = type_(
    "rcl_interfaces/msg/ListParametersResult",
    {"names": sequence[str], "prefixes": sequence[str]},
)
REAL = {"from_value": float64, "to_value": float64, "step": float64}
WHOLE = {"from_value": int64, "to_value": int64, "step": uint64}
Descriptor = type_(
    "rcl_interfaces/msg/ParameterDescriptor",
    {
        "name": str,
        "type": uint8,
        "description": str,
        "additional_constraints": str,
        "read_only": bool,
        "dynamic_typing": bool,
        "floating_point_range": sequence[
            type_("rcl_interfaces/msg/FloatingPointRange", REAL), 1
        ],
        "integer_range": sequence[type_("rcl_interfaces/msg/IntegerRange", WHOLE), 1],
    },
)
NAMES = {"names": sequence[str]}
SERVICES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "get_state": ("lifecycle_msgs/srv/GetState", EMPTY, {"current_state": State}),
    "change_state": (
        "lifecycle_msgs/srv/ChangeState",
        {"transition": Transition},
        {"success": bool},
    ),
    "get_available_states": (
        "lifecycle_msgs/srv/GetAvailableStates",
        EMPTY,
        {"available_states": sequence[State]},
    ),
    "get_available_transitions": (
        "lifecycle_msgs/srv/GetAvailableTransitions",
        EMPTY,
        {"available_transitions": sequence[Description]},
    ),
    "get_transition_graph": (
        "lifecycle_msgs/srv/GetAvailableTransitions",
        EMPTY,
        {"available_transitions": sequence[Description]},
    ),
    "list_parameters": (
        "rcl_interfaces/srv/ListParameters",
        {"prefixes": sequence[str], "depth": uint64},
        {"result": Listed},
    ),
    "get_parameters": (
        "rcl_interfaces/srv/GetParameters",
        NAMES,
        {"values": sequence[Value]},
    ),
    "get_parameter_types": (
        "rcl_interfaces/srv/GetParameterTypes",
        NAMES,
        {"types": sequence[uint8]},
    ),
    "describe_parameters": (
        "rcl_interfaces/srv/DescribeParameters",
        NAMES,
        {"descriptors": sequence[Descriptor]},
    ),
    "set_parameters": (
        "rcl_interfaces/srv/SetParameters",
        {"parameters": sequence[Parameter]},
        {"results": sequence[Result]},
    ),
    "set_parameters_atomically": (
        "rcl_interfaces/srv/SetParametersAtomically",
        {"parameters": sequence[Parameter]},
        {"result": Result},
    ),
}
NODE = "/lab/Valve_0"
HEAD = {"rmw_client": uint64, "rmw_sequence": int64}


class Mode(IntEnum):
    SLOW = 0
    FAST = 1


@dataclass
class Settings:
    gain: float = 1.0
    steps: int = 3
    on: bool = False
    title: str = "valve"
    mode: Mode = Mode.SLOW
    limits: list[float] = field(default_factory=lambda: [1.0, 2.0])
    octets: bytes = b"\x01\x02"
    huge: int = 1 << 63


class Valve(Component):
    """A component that enters ERROR when its gain is 9."""

    profile: ClassVar[ComponentProfile] = ComponentProfile(
        "Valve",
        rate=200.0,
        configuration=(
            ParameterProfile(
                *("gain", "gain", "double", "1.0", 0.0, 10.0),
                unit="1/s",
                description="How fast",
            ),
            ParameterProfile("loop.steps", "steps", "short", "3", 1),
            ParameterProfile("loop.on", "on", "boolean", "false"),
            ParameterProfile(
                "title", "title", "string", "valve", constraint="(valve,b)"
            ),
            ParameterProfile("mode", "mode", "lab::Mode", "SLOW"),
            ParameterProfile("limits", "limits", "sequence<double>", "1.0,2.0"),
            ParameterProfile("octets", "octets", "sequence<octet>", "1,2"),
            ParameterProfile("huge", "huge", "unsigned long long", str(1 << 63)),
        ),
    )

    def __init__(self, instance_name: str) -> None:
        super().__init__(instance_name)
        self.config = self.add_configuration(Settings())

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        return RTC_ERROR if self.config.gain == 9.0 else RTC_OK


class Peer:
    """A client of services and a reader of topics, by names and types of ROS 2 alone."""

    def call(self, name: str, **members: Any) -> Any:
        raise NotImplementedError

    def read(self, topic: str, type_: Any) -> Callable[[], list[Any]]:
        raise NotImplementedError


class DdsPeer(Peer):
    def __init__(self) -> None:
        self._participant = participant()

    def call(self, name: str, **members: Any) -> Any:
        from cyclonedds.pub import DataWriter
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        service, request, reply = SERVICES[name]
        types = (
            type_(f"{service}_Request", HEAD | request),
            type_(f"{service}_Response", HEAD | reply),
        )
        topics = f"rq{NODE}/{name}Request", f"rr{NODE}/{name}Reply"
        one, other = (
            Topic(self._participant, *pair) for pair in zip(topics, types, strict=True)
        )
        writer = DataWriter(self._participant, one, reliable("clientid"))
        reader = DataReader(self._participant, other, reliable("clientid"))
        until(writer.get_matched_subscriptions)
        until(reader.get_matched_publications)
        members = members or {"structure_needs_at_least_one_member": 0}
        writer.write(types[0](rmw_client=7, rmw_sequence=1, **members))
        [found] = until(lambda: reader.take(8))
        assert (found.rmw_client, found.rmw_sequence) == (7, 1)
        return found

    def read(self, topic: str, type_: Any) -> Callable[[], list[Any]]:
        from cyclonedds.qos import Policy, Qos
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        every = Qos(Policy.History.KeepAll, base=reliable())
        topic_ = Topic(self._participant, f"rt{topic}", type_)
        reader = DataReader(self._participant, topic_, every)
        until(reader.get_matched_publications)
        return lambda: list(reader.take(64))


class ZenohPeer(Peer):
    def __init__(self, session: Any, stack: ExitStack) -> None:
        self._session = session
        self._stack = stack

    def call(self, name: str, **members: Any) -> Any:
        service, request, reply = SERVICES[name]
        scope, _, last = service.rpartition("/")
        # The hash of the type, which tests/interop compares, may be any.
        key = f"{DOMAIN}{NODE}/{name}/{scope.replace('/', '::')}::dds_::{last}_/*"
        members = members or {"structure_needs_at_least_one_member": 0}
        payload = type_(f"{service}_Request", request)(**members).serialize()
        attachment = struct.pack("<qqB16s", 3, 5, 16, bytes(range(16)))

        def replies() -> Any:
            options = {"payload": payload, "attachment": attachment}
            target = zenoh.QueryTarget.ALL
            return [r.ok for r in self._session.get(key, target=target, **options)]

        [sample] = until(replies)
        response = type_(f"{service}_Response", reply)
        return response.deserialize(sample.payload.to_bytes())

    def read(self, topic: str, type_: Any) -> Callable[[], list[Any]]:
        came: list[Any] = []
        name = type_.__idl_typename__.replace(".", "::")
        key = f"{DOMAIN}{topic}/{name}/*"

        def take(sample: Any) -> None:
            came.append(type_.deserialize(sample.payload.to_bytes()))

        self._stack.callback(self._session.declare_subscriber(key, take).undeclare)

        def taken() -> list[Any]:
            found = came[:]
            del came[: len(found)]
            return found

        return taken


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


@pytest.fixture(params=["dds", "zenoh"])
def shown(request: pytest.FixtureRequest, stack: ExitStack) -> tuple[System, Peer]:
    """Yield a system in real time, whose component is a managed node, and a peer on its network."""
    peer: Peer
    if request.param == "dds":
        from rtgen.runtime.ros2.dds import open_dds

        network: Any = open_dds(RosNode("process", "/lab", DOMAIN))
        peer = DdsPeer()
    else:
        network, session, _ = zenoh_pair(stack)
        peer = ZenohPeer(session, stack)
    stack.callback(network.close)
    system = stack.enter_context(System(RealClock()))
    system.add(Valve("Valve-0"))
    system.run(1)
    classes = message_classes(*INTERFACES)
    nodes = {"Valve-0": "Valve_0"}
    stack.callback(ManagedNodes(network, system, nodes, classes, "/lab").close)
    return system, peer


def states(descriptions: Any) -> list[tuple[int, str, str, str]]:
    return [
        (d.transition.id, d.transition.label, d.start_state.label, d.goal_state.label)
        for d in descriptions
    ]


def test_the_life_cycle(shown: tuple[System, Peer]) -> None:
    """Requests of `ros2 lifecycle`: by id, by label, with all its answers."""
    system, peer = shown
    events = peer.read(f"{NODE}/transition_event", TransitionEvent)

    def state() -> tuple[int, str]:
        found = peer.call("get_state").current_state
        return found.id, found.label

    def change(id_: int, label: str) -> bool:
        wanted = Transition(id=id_, label=label)
        return bool(peer.call("change_state", transition=wanted).success)

    assert state() == (2, "inactive")
    possible = peer.call("get_available_transitions").available_transitions
    assert states(possible) == [(3, "activate", "inactive", "active")]
    assert not change(1, "")
    assert not change(4, "")
    # A label has priority over the id.
    assert not change(3, "configure")
    assert change(3, "")
    assert state() == (3, "active")
    assert change(0, "deactivate")
    assert state() == (2, "inactive")
    system.configure("Valve-0", "gain", "9.0")
    assert change(3, "")
    until(lambda: state() == (15, "errorprocessing"))
    system.configure("Valve-0", "gain", "1.0")
    assert change(60, "reset")
    assert state() == (2, "inactive")
    known = peer.call("get_available_states").available_states
    assert [(one.id, one.label) for one in known] == list(STATES.values())
    graph = peer.call("get_transition_graph").available_transitions
    assert len(states(graph)) == len(TRANSITIONS)
    came: list[Any] = []
    until(lambda: len(came) >= 5 or came.extend(events()))  # type: ignore[func-returns-value]
    assert states(came) == [
        (3, "activate", "inactive", "active"),
        (4, "deactivate", "active", "inactive"),
        (3, "activate", "inactive", "active"),
        (99, "transition_error", "active", "errorprocessing"),
        (60, "reset", "errorprocessing", "inactive"),
    ]
    assert all(event.timestamp for event in came)


def value(kind: Kind, found: Any) -> Any:
    empty = [b"", [], [], [], []]
    blank: list[Any] = [kind, False, 0, 0.0, "", *empty]
    blank[kind] = found
    return Value(*blank)


def test_parameters(shown: tuple[System, Peer]) -> None:
    """Requests of `ros2 param`: list, read, describe and set."""
    system, peer = shown
    events = peer.read("/parameter_events", ParameterEvent)
    listed = peer.call("list_parameters", prefixes=["loop"], depth=1).result
    assert (list(listed.names), list(listed.prefixes)) == (
        ["loop.steps", "loop.on"],
        ["loop"],
    )
    values = peer.call("get_parameters", names=["gain", "mode", "none"]).values
    assert values[0].double_value == 1.0
    assert (values[1].type, values[1].string_value) == (4, "SLOW")
    assert values[2].type == 0
    types = peer.call("get_parameter_types", names=["loop.steps", "limits"]).types
    assert list(types) == [2, 8]
    [shown_] = peer.call("describe_parameters", names=["gain"]).descriptors
    assert (shown_.name, shown_.type, shown_.description) == (
        "gain",
        3,
        "How fast [1/s]",
    )
    [limits] = shown_.floating_point_range
    assert (limits.from_value, limits.to_value, limits.step) == (0.0, 10.0, 0.0)
    parameters = [
        Parameter("gain", value(Kind.DOUBLE, 2.5)),
        Parameter("loop.steps", value(Kind.STRING, "many")),
    ]
    results = peer.call("set_parameters", parameters=parameters).results
    assert [result.successful for result in results] == [True, False]
    assert results[1].reason == "parameter 'loop.steps' is of type integer, not string"
    came: list[Any] = []
    until(lambda: came or came.extend(events()))  # type: ignore[func-returns-value]
    [changed] = came[0].changed_parameters
    assert came[0].node == NODE
    assert (changed.name, changed.value.double_value) == ("gain", 2.5)
    parameters = [
        Parameter("gain", value(Kind.DOUBLE, 4.0)),
        Parameter("loop.steps", value(Kind.INTEGER, 0)),
    ]
    result = peer.call("set_parameters_atomically", parameters=parameters).result
    assert not result.successful
    assert "it must be at least 1" in result.reason
    assert system.component("Valve-0").configuration_sets.texts()["gain"] == "2.5"


def test_both_nodes_are_in_the_graph_of_zenoh(stack: ExitStack) -> None:
    network, plain, _ = zenoh_pair(stack)
    stack.callback(network.close)
    system = stack.enter_context(System(RealClock()))
    system.add(Valve("Valve0"))
    classes = message_classes(*INTERFACES)
    nodes = ManagedNodes(network, system, {"Valve0": "Valve0"}, classes, "/robot")
    stack.callback(nodes.close)

    def tokens() -> list[str]:
        found = plain.liveliness().get(f"@ros2_lv/{DOMAIN}/**")
        return sorted(str(reply.ok.key_expr) for reply in found if reply.ok)

    # A node each; 11 services and three publishers.
    found = until(lambda: tokens() if len(tokens()) == 16 else [])
    kinds = [token.split("/")[5:] for token in found]
    assert ["NN", "%", "%robot", "node"] in kinds
    assert ["NN", "%", "%robot", "Valve0"] in kinds
    others = [kind for kind in kinds if kind[0] != "NN"]
    assert {kind[3] for kind in others} == {"Valve0"}
    number = next(t.split("/")[3] for t in found if t.endswith("NN/%/%robot/Valve0"))
    own = [token.split("/")[3] for token in found if "/SS/" in token or "/MP/" in token]
    assert set(own) == {number}
    names = {kind[4].removeprefix("%robot%Valve0%") for kind in others}
    assert names == {*SERVICES, "transition_event", "%parameter_events", "%rosout"}


def test_both_nodes_are_in_the_graph_of_dds(stack: ExitStack) -> None:
    from rtgen.runtime.ros2.dds import open_dds
    from rtgen.runtime.ros2.network import RosTopic

    network = open_dds(RosNode("process", "/lab", DOMAIN))
    stack.callback(network.close)
    class_ = message_classes("std_msgs/msg/Float32")["std_msgs/msg/Float32"]
    announced = []
    for node in ("", "Valve0", "Valve0"):
        network.medium._announce()
        announced.append({k: len(v.writers) for k, v in network.medium._nodes.items()})
        network.publisher(
            RosTopic(f"/x{len(announced)}", class_, node), PROFILES["default"]
        )
    assert announced == [{"process": 0}, {"process": 1}, {"process": 1, "Valve0": 1}]


def test_a_transition_that_is_not_made_in_time(stack: ExitStack) -> None:
    """And a request that waits when the nodes are closed: both are answered."""
    from rtgen.runtime import SimulatedClock
    from rtgen.runtime.ros2.life_cycle import LifeCycle

    classes = message_classes(*INTERFACES)
    wanted = classes["lifecycle_msgs/msg/Transition"](id=3, label="")
    request = classes["lifecycle_msgs/srv/ChangeState_Request"](transition=wanted)
    system = stack.enter_context(System(SimulatedClock()))
    system.add(Valve("V0"))
    # Nothing runs, so that no request is executed.
    assert LifeCycle(system, "V0", 0.01).change_state(request) == {"success": False}
    waiting = LifeCycle(system, "V0", 1000.0)
    found: list[Any] = []
    thread = threading.Thread(
        target=lambda: found.append(waiting.change_state(request))
    )
    thread.start()
    until(lambda: waiting._changes)
    waiting.close()
    thread.join()
    assert found == [{"success": False}]
    assert waiting.change_state(request) == {"success": False}


class Request:
    def __init__(self, **members: Any) -> None:
        self.__dict__.update(members)


def own() -> tuple[Parameters, ConfigurationSets]:
    sets = Valve("V0").configuration_sets
    return Parameters(sets), sets


KINDS = {
    "gain": (Kind.DOUBLE, "double_value", 1.0),
    "loop.steps": (Kind.INTEGER, "integer_value", 3),
    "loop.on": (Kind.BOOL, "bool_value", False),
    "title": (Kind.STRING, "string_value", "valve"),
    "mode": (Kind.STRING, "string_value", "SLOW"),
    "limits": (Kind.DOUBLE_ARRAY, "double_array_value", [1.0, 2.0]),
    "octets": (Kind.BYTE_ARRAY, "byte_array_value", b"\x01\x02"),
    "huge": (Kind.STRING, "string_value", str(1 << 63)),
    "configuration.active_config": (Kind.STRING, "string_value", "default"),
}


def test_values_by_type() -> None:
    parameters, _ = own()
    for name, (kind, member, expected) in KINDS.items():
        assert parameters.value(name) == {"type": kind, member: expected}
    assert parameters.value("limits", "")["type"] is Kind.DOUBLE_ARRAY


def parameter(name: str, kind: Kind, found: Any) -> Request:
    return Request(
        name=name, value=Request(type=kind, **{f"{kind.name.lower()}_value": found})
    )


@pytest.mark.parametrize(
    ("name", "kind", "given", "reason"),
    [
        ("gain", Kind.INTEGER, 2, ""),
        ("gain", Kind.DOUBLE, 11.0, "it must be at most 10.0 1/s"),
        ("gain", Kind.DOUBLE, float("nan"), "it must be at least 0.0 1/s"),
        ("gain", Kind.STRING, "2", "is of type double, not string"),
        ("limits", Kind.DOUBLE_ARRAY, [0.5], ""),
        ("limits", Kind.INTEGER_ARRAY, [1, 3], ""),
        ("octets", Kind.BYTE_ARRAY, b"\xff\x00", ""),
        ("octets", Kind.INTEGER_ARRAY, [256], "it must be between 0 and 255"),
        ("loop.on", Kind.BOOL, True, ""),
        ("loop.steps", Kind.INTEGER, 40_000, "it must be between -32768 and 32767"),
        ("mode", Kind.STRING, "FAST", ""),
        ("mode", Kind.STRING, "FASTER", "it must be one of SLOW, FAST"),
        ("huge", Kind.STRING, str((1 << 64) - 1), ""),
        ("title", Kind.STRING, "c", "its constraint is (valve,b)"),
        ("none", Kind.BOOL, True, "there is no parameter 'none'; known: gain,"),
        ("configuration.active_config", Kind.STRING, "x", "no configuration set 'x'"),
    ],
)
def test_values_that_are_set(name: str, kind: Kind, given: Any, reason: str) -> None:
    parameters, _ = own()
    before = parameters.value(name)
    wanted = Request(parameters=[parameter(name, kind, given)])
    [result] = parameters.set_parameters(wanted)["results"]
    assert reason in result.get("reason", "")
    assert result["successful"] is not bool(reason)
    assert (parameters.value(name) == before) is bool(reason)


def test_an_unset_value_is_refused() -> None:
    parameters, _ = own()
    for number in (0, 77):
        wanted = Request(name="gain", value=Request(type=number))
        [result] = parameters.set_parameters(Request(parameters=[wanted]))["results"]
        assert "parameter 'gain' is of type double, not" in result["reason"]


def test_a_set_is_changed_with_its_values() -> None:
    """All of a request take effect at once, in the set that it activates."""
    parameters, sets = own()
    sets.set("gain", "3.0", "fast")
    wanted = [
        parameter("loop.steps", Kind.INTEGER, 5),
        parameter("configuration.active_config", Kind.STRING, "fast"),
    ]
    result = parameters.set_parameters_atomically(Request(parameters=wanted))
    assert result == {"result": {"successful": True}}
    assert sets.active == "fast"
    assert sets.texts("fast")["loop.steps"] == "5"
    assert sets.texts()["loop.steps"] == "3"


@pytest.mark.parametrize(
    ("prefixes", "depth", "names"),
    [
        ([], 0, [*KINDS]),
        ([], 1, [name for name in KINDS if "." not in name]),
        (["gain", "loop"], 0, ["gain", "loop.steps", "loop.on"]),
        (["loo"], 0, []),
        (["configuration"], 1, ["configuration.active_config"]),
    ],
)
def test_names_below_prefixes(
    prefixes: list[str], depth: int, names: list[str]
) -> None:
    parameters, _ = own()
    found = parameters.list_parameters(Request(prefixes=prefixes, depth=depth))
    assert sorted(found["result"]["names"]) == sorted(names)


def test_too_many_names_are_refused() -> None:
    parameters, _ = own()
    names = ["gain"] * 10_001
    for name in ("get_parameters", "get_parameter_types", "describe_parameters"):
        with pytest.raises(ServiceError, match="10001 items"):
            getattr(parameters, name)(Request(names=names))
    with pytest.raises(ServiceError, match="10001 items"):
        parameters.list_parameters(Request(prefixes=names, depth=0))


def test_ranges_of_integers() -> None:
    parameters, _ = own()
    found = parameters.describe_parameters(Request(names=["loop.steps", "title", "x"]))
    steps, title, unknown = found["descriptors"]
    assert steps["integer_range"] == [{"from_value": 1, "to_value": (1 << 63) - 1}]
    assert title["additional_constraints"] == "(valve,b)"
    assert unknown == {"name": "x", "type": Kind.NOT_SET}
