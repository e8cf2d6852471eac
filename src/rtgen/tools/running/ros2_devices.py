"""Nodes of a project's CANopen buses in a run with `--ros2`: topics and parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.model import System, SystemComponent
from rtgen.compiler.systems.rules import ROS_TOPIC
from rtgen.ros2.devices import ObjectTopic, RosDevice, description
from rtgen.runtime.canopen.master.proxy import CanopenProxy
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.ros2.managed import INTERFACES, ParameterNodes
from rtgen.runtime.ros2.network import RosNetwork, RosNode, RosTopic
from rtgen.runtime.ros2.objects import (
    ObjectJoint,
    ObjectParameters,
    ObjectProfile,
    ObjectTopics,
)

if TYPE_CHECKING:
    from rtgen.compiler.model.can_bus import Bus

_MANAGER = "CanopenManager"


def with_buses(system: System, devices: Iterable[RosDevice]) -> System:
    """Return a system with a manager for each bus, and a proxy for each of its nodes."""
    added: list[SystemComponent] = []
    buses: dict[str, Bus] = {}
    for device in devices:
        bus = device.bus
        network = ("network", bus.name)
        if bus.name not in buses:
            instance = f"{_MANAGER}{len(buses)}"
            added.append(_component(instance, _MANAGER, [network], device))
        buses[bus.name] = bus
        settings = [network, ("node_id", str(device.node.id))]
        name = f"{device.proxy}_{device.name}"
        added.append(_component(name, device.proxy, settings, device))
    return replace(system, components=(*system.components, *added))


def _component(
    instance: str, type_: str, settings: list[tuple[str, str]], device: RosDevice
) -> SystemComponent:
    return SystemComponent(
        instance=instance,
        type=type_,
        id="",
        path_uri="",
        span=device.node.span,
        configuration=(("default", tuple(settings)),),
    )


def require_free(devices: Iterable[RosDevice], nodes: Collection[str]) -> None:
    """Raise InputError for nodes of buses that have the name of a component's node."""
    findings: list[Diagnostic] = []
    for device in devices:
        if device.name in nodes:
            message = f"the component and the node of {device.bus.file} are both {device.name!r}"
            hint = "rename one, or [ros2] managed_nodes = false, or boards = false"
            findings.append(ROS_TOPIC.at(device.node.span, message, hint=hint))
    if findings:
        raise InputError(findings)


def present(
    devices: Iterable[RosDevice], running: runtime.System
) -> dict[str, tuple[RosDevice, CanopenProxy]]:
    """Return the nodes whose proxies are in this process, by name."""
    proxies = {
        (c.config.network, c.config.node_id): c
        for c in map(running.component, running.instances)
        if isinstance(c, CanopenProxy)
    }
    return {
        device.name: (device, proxies[device.bus.name, device.node.id])
        for device in devices
        if (device.bus.name, device.node.id) in proxies
    }


def join_devices(
    found: Mapping[str, tuple[RosDevice, CanopenProxy]],
    network: RosNetwork,
    node: RosNode,
    running: runtime.System,
    message_classes: Callable[..., dict[str, Any]],
    files: ExitStack,
) -> None:
    """Connect the objects of nodes with ROS 2 until `files` is closed. Raises Ros2Error."""
    connected = {
        (connector.target.owner, connector.target.name)
        for connector in running.connectors
        if isinstance(connector, DataConnector)
    }
    nodes: dict[str, object] = {}
    for device, proxy in found.values():
        classes = message_classes(*{t.message for t in device.topics})
        joints = [
            ObjectJoint(_topic(device, topic, classes, node), ports, topic.start)
            for topic in device.topics
            if (ports := tuple(_ports(topic, proxy, connected)))
        ]
        files.callback(ObjectTopics(network, joints, proxy.stamp).close)
        nodes[node.qualified(device.name)] = ObjectParameters(
            proxy, [*_profiles(device)]
        )
    if nodes:
        made = ParameterNodes(network, nodes, message_classes(*INTERFACES))
        files.callback(made.close)


def _topic(
    device: RosDevice, topic: ObjectTopic, classes: Mapping[str, Any], node: RosNode
) -> RosTopic:
    name = node.qualified(f"{device.name}/{topic.name}")
    return RosTopic(name, classes[topic.message], device.name)


def _ports(
    topic: ObjectTopic, proxy: CanopenProxy, connected: Collection[tuple[str, str]]
) -> Iterator[tuple[Any, str]]:
    """Yield the ports of an object; InPorts that the system connects are left to it."""
    for name, member in topic.places:
        if topic.sent:
            yield proxy.out_ports[name], member
        elif (proxy.instance_name, name) not in connected:
            yield proxy.in_ports[name], member


def _profiles(device: RosDevice) -> Iterator[ObjectProfile]:
    for each in device.parameters:
        variable = each.quantity.variable
        yield ObjectProfile(
            name=each.name,
            number=variable.number,
            kind=each.kind,
            factor=each.quantity.factor,
            readable=variable.access.readable,
            writable=variable.access.writable,
            low=each.low,
            high=each.high,
            description=description(each),
        )
