"""Objects of CANopen drives in ROS 2: a drive on a bus is moved by a topic, and set by parameters.

The other side is cyclonedds alone, with names and types as ROS 2 has them.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any
from uuid import uuid4

import pytest
from msgspec.structs import replace
from patience import until
from test_networks import DOMAIN, participant, reliable

from refnav.epos_drive_device import EposDriveDevice
from refrobots.canopen.manager import CanopenManager
from refrobots.components.epos_drive_proxy import EposDriveProxy
from rtgen.compiler import compilation
from rtgen.compiler.project import load
from rtgen.compiler.typemap.canopen.ports import Quantity
from rtgen.facts.canopen import DataType
from rtgen.ros2.devices import RosDevice, devices, message_of
from rtgen.runtime import RTC_OK, RealClock, System
from rtgen.runtime.library.rtc import Time
from rtgen.runtime.ros2.managed import EVENT_INFO, INTERFACES
from rtgen.runtime.ros2.network import RosNode, RosService, RosTopic
from rtgen.runtime.ros2.objects import of_message, to_message
from rtgen.runtime.ros2.parameters import Kind
from rtgen.runtime.ros2.types import decoded, encoded, made
from rtgen.tools.running.ros2_classes import message_classes
from rtgen.tools.running.ros2_devices import join_devices, present

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

pytestmark = pytest.mark.waits

SPACE = f"/bus_{uuid4().hex[:8]}"
OPERATION_ENABLED = 0x27


@pytest.fixture(scope="module")
def nodes() -> list[RosDevice]:
    project = load()
    wanted = ("epos_drive.eds", "rh3_beego.toml")
    sources = tuple(p for p in project.sources if p.name in wanted)
    read = compilation.read(replace(project, sources=sources, adapters=()))
    return devices(read.model)


def test_names_and_messages(nodes: list[RosDevice]) -> None:
    left, right = nodes
    assert (left.name, right.name) == ("left", "right")
    topics = {t.name: (t.message, t.sent, t.places) for t in left.topics}
    assert topics["position_actual_value"] == (
        *("std_msgs/msg/Float64", True),
        (("tpdo2", "Position_actual_value"),),
    )
    assert topics["target_torque"] == (
        *("std_msgs/msg/Int16", False),
        (("rpdo4", "Target_torque"),),
    )
    parameters = {p.name: p for p in left.parameters}
    assert "target_velocity" not in parameters
    assert parameters["profile_acceleration"].kind == "u32"
    assert parameters["device_type"].kind == "u32"


VALUES = {
    DataType.BOOLEAN: (True, False),
    DataType.INTEGER8: (-128, 127),
    DataType.UNSIGNED8: (0, 255),
    DataType.INTEGER24: (-(1 << 23), 5),
    DataType.UNSIGNED32: (0, (1 << 32) - 1),
    DataType.INTEGER64: (-(1 << 63), 1),
    DataType.UNSIGNED64: ((1 << 64) - 1,),
    DataType.REAL32: (0.5, -1e30),
    DataType.REAL64: (0.1, -1e300),
    DataType.VISIBLE_CHAR: ("a", "\xff", "\0"),
    DataType.VISIBLE_STRING: ("", "drive 24/5"),
    DataType.UNICODE_STRING: ("", "表"),
    DataType.OCTET_STRING: (b"", b"\x00\xff"),
    DataType.DOMAIN: (b"abc",),
    DataType.TIME_OF_DAY: (Time(0, 0), Time((1 << 31) - 1, 999_999_999)),
    DataType.TIME_DIFFERENCE: (Time(5, 7),),
}


@pytest.mark.parametrize("type_", VALUES, ids=lambda each: each.name)
def test_values_of_all_types(type_: DataType, nodes: list[RosDevice]) -> None:
    [drive] = {id(n.node.kind): n.node.kind for n in nodes}.values()
    variable = replace(next(iter(drive.device.variables)), data_type=type_)
    name = message_of(Quantity("x", variable))
    topic = RosTopic("/x", message_classes(name)[name])
    for value in VALUES[type_]:
        octets = encoded(to_message(topic, value))
        message = decoded(topic.type, octets)
        back = of_message(topic, message, value)
        assert type(back) is type(value)
        single = type_ is DataType.REAL32
        assert back == (pytest.approx(value, rel=1e-6) if single else value)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


def started(stack: ExitStack) -> System:
    """Return a system with two drives, their proxies and a manager on a bus of this process."""
    system = System(RealClock())
    stack.callback(system.close)
    channel = uuid4().hex
    parts = [
        *((EposDriveDevice(f"Drive{n}"), n) for n in (1, 2)),
        (CanopenManager("Manager0"), None),
        *((EposDriveProxy(f"Proxy{n}"), n) for n in (1, 2)),
    ]
    for component, number in parts:
        sets = component.configuration_sets
        sets.set("network", "rh3_beego")
        sets.set("channel", channel)
        if number is not None:
            sets.set("node_id", str(number))
        system.add(component, 100.0)
    for component, _ in parts:
        assert system.activate(component.instance_name) is RTC_OK
    return system


def test_a_drive_is_moved_and_set(nodes: list[RosDevice], stack: ExitStack) -> None:
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import float64, int8, uint16
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    from rtgen.runtime.ros2.dds import open_dds

    system = started(stack)
    network = open_dds(RosNode("rh3", SPACE, DOMAIN))
    stack.callback(network.close)
    found = present(nodes, system)
    assert [*found] == ["left", "right"]
    ros = RosNode("rh3", SPACE, DOMAIN)
    join_devices(found, network, ros, system, message_classes, stack)
    thread = threading.Thread(
        target=system.run, kwargs={"until": lambda _: ended.is_set()}
    )
    ended = threading.Event()
    thread.start()
    stack.callback(thread.join)
    stack.callback(ended.set)
    part = participant()

    def topic(name: str, message: str, type_: Any) -> Any:
        struct = make_idl_struct(
            f"{message}_", f"std_msgs::msg::dds_::{message}_", {"data": type_}
        )
        return Topic(part, f"rt{SPACE}/left/{name}", struct), struct

    def writer(name: str, message: str, type_: Any) -> Any:
        made_topic, struct = topic(name, message, type_)
        end = DataWriter(part, made_topic, reliable())
        until(end.get_matched_subscriptions)
        return lambda value: end.write(struct(data=value))

    def reader(name: str, message: str, type_: Any) -> Any:
        end = DataReader(part, topic(name, message, type_)[0], reliable())
        until(end.get_matched_publications)
        return end

    position = reader("position_actual_value", "Float64", float64)
    status = reader("statusword", "UInt16", uint16)
    mode = writer("modes_of_operation", "Int8", int8)
    control = writer("controlword", "UInt16", uint16)
    velocity = writer("target_velocity", "Float64", float64)
    until(lambda: all(system.component(f"Proxy{n}").is_active for n in (1, 2)))
    mode(3)

    def has_status(word: int, value: int) -> bool:
        control(word)
        return any(s.data & 0x6F == value for s in status.take(64))

    until(lambda: has_status(0x80, 0x40) or has_status(0x06, 0x21))
    until(lambda: has_status(0x06, 0x21))
    until(lambda: has_status(0x07, 0x23))
    until(lambda: has_status(0x0F, OPERATION_ENABLED))
    velocity(3.0)
    until(lambda: any(s.data > 0.1 for s in position.take(64)))

    call = parameters(network, "left")
    names = call("list_parameters", "ListParameters").result.names
    assert {"device_type", "profile_acceleration"} <= {*names}
    assert "target_velocity" not in names
    [value] = call("get_parameters", "GetParameters", names=["device_type"]).values
    assert value.type == Kind.INTEGER
    assert value.integer_value & 0xFFFF == 402
    change = {"name": "profile_acceleration", "value": real(20.0)}
    [result] = call("set_parameters", "SetParameters", parameters=[change]).results
    assert result.successful, result.reason
    [value] = call(
        "get_parameters", "GetParameters", names=["profile_acceleration"]
    ).values
    assert value.double_value == pytest.approx(20.0, rel=1e-4)
    for wrong, why in (
        (
            {"name": "device_type", "value": {"type": 2, "integer_value": 1}},
            "read-only",
        ),
        ({"name": "profile_acceleration", "value": real(-1.0)}, "is under 0"),
        (
            {"name": "profile_acceleration", "value": {"type": 4}},
            "of type double, not string",
        ),
        ({"name": "nothing", "value": real(1.0)}, "there is no parameter 'nothing'"),
    ):
        [result] = call("set_parameters", "SetParameters", parameters=[wrong]).results
        assert not result.successful
        assert why in result.reason
    [described] = call(
        "describe_parameters", "DescribeParameters", names=["device_type"]
    ).descriptors
    assert described.read_only
    assert described.description.startswith("Device type (1000:0)")


def real(value: float) -> dict[str, Any]:
    return {"type": 3, "double_value": value}


def parameters(network: Any, node: str) -> Any:
    """Return a function that calls a parameter service of a node."""
    classes = message_classes(*INTERFACES)

    def call(name: str, type_: str, **members: Any) -> Any:
        request, response = (
            classes[f"rcl_interfaces/srv/{type_}_{end}"]
            for end in ("Request", "Response")
        )
        service = RosService(
            request, response, f"{SPACE}/{node}/{name}", classes[EVENT_INFO]
        )
        client = network.client(service)
        return decoded(
            response, client(encoded(made(request._descriptor_, members)), 20.0)
        )

    return call
