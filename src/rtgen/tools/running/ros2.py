"""The option `--ros2` of `rtgen run`: connects ports to topics of ROS 2 (`[ros2.topics]`)."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.compiler.project import Project
from rtgen.compiler.project.ros2 import Ros2Settings, ServiceEntry, TopicEntry
from rtgen.compiler.systems.rules import ROS_TOPIC
from rtgen.facts import ros_names
from rtgen.facts.adapter_constants import parsed
from rtgen.facts.connector_properties import MARSHALING, ROS_SET
from rtgen.facts.ros import is_interface
from rtgen.facts.ros_marshaling import DEFAULT_TOPIC, messages_for, parse
from rtgen.facts.ros_qos_words import profiles, topic_of
from rtgen.tools.kit.console import Console
from rtgen.tools.running.ros2_classes import message_classes
from rtgen.tools.running.ros2_networks import open_network
from rtgen.tools.running.ros2_time import RosTime
from rtgen.tools.running.ros2_transforms import frames_of, publish_transforms

if TYPE_CHECKING:
    from rtgen.runtime.ros2.descriptions import TypeDescriptions
    from rtgen.runtime.ros2.marshaling import Marshaling
    from rtgen.runtime.ros2.network import RosNetwork, RosNode
    from rtgen.runtime.ros2.ports import Joint
    from rtgen.runtime.ros2.services import Answer, EventJoint, ServiceJoint
    from rtgen.tools.recording.bag_recorder import BagRecorder
    from rtgen.tools.running.ros2_boards import Boards

_DOMAIN = "ROS_DOMAIN_ID"
_LAST_DOMAIN = 232


def join(
    kind: str,
    files: ExitStack,
    running: runtime.System,
    project: Project,
    name: str,
    console: Console,
    clock: RosTime,
    *,
    bag: BagRecorder | None = None,
    boards: Boards | None = None,
) -> Callable[[float], None]:
    """Connect ports to topics until `files` is closed. `name` is that of the system.

    `bag` records the messages; `boards` are those whose functions are services. Return a function
    that waits, in seconds, for simulated time.
    """
    settings = project.ros2
    from rtgen.runtime.ros2.managed import INTERFACES, ManagedNodes
    from rtgen.runtime.ros2.network import Ros2Error, RosNode
    from rtgen.runtime.ros2.ports import RosPorts
    from rtgen.runtime.ros2.services import RosServices
    from rtgen.runtime.ros2.transforms import MESSAGE as TRANSFORMS

    node = RosNode(
        settings.node or ros_names.node_name(name),
        settings.namespace,
        _domain() if settings.domain is None else settings.domain,
    )
    nodes = _nodes(running) if settings.managed_nodes else {}
    joints = _joints(settings, running, node, nodes, others=boards is not None)
    services = _service_joints(settings, running, node, nodes)
    frames = frames_of(settings, running, nodes)
    found = {}
    if boards is not None and boards.devices:
        from rtgen.tools.running.ros2_devices import join_devices, present, require_free

        found = present(boards.devices, running)
        require_free((device for device, _ in found.values()), nodes.values())
    served = [] if boards is None else [*_of_boards(boards, running, node, nodes)]
    try:
        network = open_network(kind, node, project, console)
        clock.prepare(network)
        if bag is not None:
            network.observe(bag.observe)
        running.closing.at_halt(network.end_calls)
        files.callback(RosPorts(network, joints).close)
        served_by = RosServices(network, services, answers=served, system=running)
        files.callback(served_by.close)
        if found:
            join_devices(found, network, node, running, message_classes, files)
        if nodes:
            classes = message_classes(*INTERFACES)
            space = settings.namespace
            managed = ManagedNodes(network, running, nodes, classes, space)
            files.callback(managed.close)
        if frames or settings.static_transforms:
            class_ = message_classes(TRANSFORMS)[TRANSFORMS]
            now = running.clock.now()
            sent = publish_transforms(network, settings, frames, class_, now)
            files.callback(sent.close)
        described = _described(network, node, nodes, project)
        files.callback(described.close)
        return clock.begin(network, running)
    except Ros2Error as error:
        raise ToolError(str(error)) from error


def topic_joints(
    project: Project, running: runtime.System, absent: Collection[str]
) -> list[Joint]:
    """Return the ports that are topics; those of `absent` components are left out.

    Raises InputError for all invalid ones.
    """
    from rtgen.runtime.ros2.network import RosNode

    settings = project.ros2
    topics = tuple(each for each in settings.topics if each.instance not in absent)
    node = RosNode("rtgen", settings.namespace)
    present = replace(settings, topics=topics)
    return _joints(present, running, node, {}, others=False)


def _described(
    network: RosNetwork, node: RosNode, nodes: Mapping[str, str], project: Project
) -> TypeDescriptions:
    """Serve the types that the nodes use. Raises Ros2Error."""
    from rtgen.runtime.ros2.descriptions import SERVICE, TypeDescriptions
    from rtgen.runtime.ros2.managed import EVENT_INFO
    from rtgen.tools.running.ros2_definitions import definitions

    classes = message_classes(SERVICE, EVENT_INFO)
    names = {"": node.name, **{name: name for name in nodes.values()}}
    space = node.namespace.rstrip("/")
    return TypeDescriptions(
        network,
        {end: f"{space}/{name}" for end, name in names.items()},
        classes,
        classes[EVENT_INFO],
        definitions([project.root, *project.include]),
    )


def _nodes(running: runtime.System) -> dict[str, str]:
    """Return the nodes of components, by instance. Raises InputError for duplicate names."""
    nodes: dict[str, str] = {}
    for instance in running.instances:
        name = ros_names.node_name(instance)
        if name in nodes.values():
            other = next(each for each in nodes if nodes[each] == name)
            message = f"{other} and {instance} would both be the node {name!r}"
            hint = "rename one, or [ros2] managed_nodes = false in rtgen.toml"
            raise InputError([ROS_TOPIC.at(None, message, hint=hint)])
        nodes[instance] = name
    return nodes


def _domain() -> int:
    text = os.environ.get(_DOMAIN, "") or "0"
    if not (text.isascii() and text.isdecimal() and int(text) <= _LAST_DOMAIN):
        raise ToolError(f"{_DOMAIN} is {text!r}, no number from 0 to {_LAST_DOMAIN}")
    return int(text)


def _joints(
    settings: Ros2Settings,
    running: runtime.System,
    node: RosNode,
    nodes: Mapping[str, str],
    *,
    others: bool,
) -> list[Joint]:
    """Return the ports with their topics. Raises InputError for all invalid ones.

    `others`: something else is in ROS 2.
    """
    from rtgen.runtime.ros2.ports import Joint

    entries = [*settings.topics, *_connected(running)]
    others = others or bool(settings.transforms or settings.static_transforms)
    if not (entries or settings.services or settings.actions or nodes or others):
        hint = (
            '[ros2.topics] "INSTANCE.PORT" = "TOPIC" in rtgen.toml, or [ros2.services]'
        )
        raise InputError([ROS_TOPIC.at(None, "no port is a topic", hint=hint)])
    diagnostics: list[Diagnostic] = []
    joints = []
    for entry in entries:
        problem = next(_problems(entry, running), None)
        if problem is not None:
            diagnostics.append(ROS_TOPIC.at(entry.span, problem))
            continue
        port = _ports(running, entry.instance)[entry.port]
        topic = node.qualified(entry.topic)
        wrong, marshaled = _marshaled(entry, running)
        diagnostics += wrong
        shown = nodes.get(entry.instance, "")
        joints.append(Joint(port, topic, entry.profile, marshaled, shown))
    if diagnostics:
        raise InputError(diagnostics)
    return joints


def _connected(running: runtime.System) -> Iterator[TopicEntry]:
    """Yield both ends of connections with `marshaling_type=ros2:...`, and disconnect them."""
    from rtgen.runtime.ports.data_ports import DataConnector

    seen = set()
    for connector in running.connectors:
        if not isinstance(connector, DataConnector):
            continue
        message = parse(connector.properties.get(MARSHALING, ""))
        if message is None:
            continue
        topic = topic_of(connector.properties) or DEFAULT_TOPIC
        fixed = parsed(connector.properties.get(ROS_SET, ""))
        ports: tuple[Any, Any] = connector.source, connector.target
        both = zip(ports, profiles(connector.properties), (fixed, {}), strict=True)
        for port, profile, constants in both:
            if (port.owner, port.name, topic, message) not in seen:
                seen.add((port.owner, port.name, topic, message))
                yield TopicEntry(
                    instance=port.owner,
                    port=port.name,
                    topic=topic,
                    profile=profile,
                    span=None,
                    message=message,
                    constants=tuple(
                        (path, each, None) for path, each in constants.items()
                    ),
                )
        running.disconnect(connector)


def _problems(entry: TopicEntry, running: runtime.System) -> Iterator[str]:
    """Yield why a port cannot be a topic."""
    if entry.instance not in running.instances:
        names = ", ".join(running.instances)
        yield f"there is no component {entry.instance!r}; known: {names}"
        return
    ports = _ports(running, entry.instance)
    if entry.port not in ports:
        names = ", ".join(ports)
        yield f"{entry.instance} has no data port {entry.port!r}; known: {names}"
        return
    if why := ros_names.violation(entry.topic):
        yield f"the topic {entry.topic!r} of {entry.instance}.{entry.port} {why}"
    name = str(ports[entry.port].type._descriptor_.name)
    possible = messages_for(name)
    if entry.message is not None:
        if entry.message not in possible:
            names = ", ".join(each.replace("/msg/", "/") for each in possible) or "none"
            yield (
                f"{entry.instance}.{entry.port} carries {name}, which cannot go as "
                f"{entry.message}; known: {names}"
            )
    elif not is_interface(name.split("::")):
        also = " or give it a marshaling_type" if possible else ""
        yield (
            f"{entry.instance}.{entry.port} carries {name}, which is not a message of ROS 2; "
            f"join it to an adapter{also}"
        )


def _service_joints(
    settings: Ros2Settings,
    running: runtime.System,
    node: RosNode,
    nodes: Mapping[str, str],
) -> list[ServiceJoint | EventJoint]:
    """Return the operations with their services, including those of actions.

    Raises InputError for all invalid ones.
    """
    from rtgen.runtime.ros2.actions import joints_of
    from rtgen.runtime.ros2.managed import EVENT_INFO
    from rtgen.runtime.ros2.network import RosService
    from rtgen.runtime.ros2.services import ServiceJoint, messages_of
    from rtgen.runtime.services.servants import ServiceError

    if not (settings.services or settings.actions):
        return []
    info = message_classes(EVENT_INFO)[EVENT_INFO]
    diagnostics: list[Diagnostic] = []
    joints: list[ServiceJoint | EventJoint] = []
    for entry in settings.services:
        try:
            port = _service_port(entry, running)
            messages = messages_of(port.interface, entry.operation)
        except (LookupError, ServiceError) as error:
            problem = str(error.args[0])
            diagnostics.append(ROS_TOPIC.at(entry.span, problem))
            continue
        shown = nodes.get(entry.instance, "")
        name = node.qualified(entry.service)
        service = RosService(*messages, name, info, shown)
        joints.append(ServiceJoint(port, entry.operation, service))
    for action in settings.actions:
        shown = nodes.get(action.instance, "")
        name = node.qualified(action.action)
        try:
            component = _component(action.instance, running)
            joints += joints_of(component, action.port, name, info, shown)
        except (LookupError, ServiceError) as error:
            diagnostics.append(ROS_TOPIC.at(action.span, str(error.args[0])))
    if diagnostics:
        raise InputError(diagnostics)
    return joints


def _of_boards(
    boards: Boards, running: runtime.System, node: RosNode, nodes: Mapping[str, str]
) -> Iterator[Answer]:
    """Yield the services of boards."""
    from rtgen.runtime.ros2.managed import EVENT_INFO
    from rtgen.runtime.ros2.network import RosService
    from rtgen.runtime.ros2.services import Answer

    info = message_classes(EVENT_INFO)[EVENT_INFO]
    for each in boards.services(running):
        name = node.qualified(each.service.name)
        shown = nodes.get(each.instance, "")
        service = RosService(each.request, each.response, name, info, shown)
        yield Answer(service, each.answer, each.instance)


def _component(instance: str, running: runtime.System) -> runtime.Component:
    """Return the component of an entry. Raises LookupError."""
    if instance not in running.instances:
        names = ", ".join(running.instances)
        raise LookupError(f"there is no component {instance!r}; known: {names}")
    return running.component(instance)


def _service_port(entry: ServiceEntry, running: runtime.System) -> Any:
    """Return the provider, or the unconnected consumer. Raises LookupError with the reason."""
    from rtgen.runtime.services.servants import operations_of

    component = _component(entry.instance, running)
    both: list[Any] = [*component.providers.values(), *component.consumers.values()]
    ports = [port for port in both if port.port == entry.port]
    if not ports:
        names = ", ".join(dict.fromkeys(port.port for port in both)) or "none"
        raise LookupError(
            f"{entry.instance} has no service port {entry.port!r}; known: {names}"
        )
    having = (p for p in ports if entry.operation in operations_of(p.interface))
    port = next(having, ports[0])
    if getattr(port, "connected", False):
        raise LookupError(f"{entry.instance}.{entry.port} is connected in the system")
    return port


def _marshaled(
    entry: TopicEntry, running: runtime.System
) -> tuple[list[Diagnostic], Marshaling | None]:
    """Return the conversion of a port's data, and what is wrong with its constants."""
    from rtgen.runtime.ros2.marshaling import ConstantError, constant_of, marshaling

    if entry.message is None:
        return [], None
    component = running.component(entry.instance)
    port = _ports(running, entry.instance)[entry.port]
    message = message_classes(entry.message)[entry.message]
    target = port.type if entry.port in component.in_ports else message
    constants, wrong = [], []
    for path, value, span in entry.constants:
        try:
            constants.append(constant_of(target, path, value))
        except ConstantError as error:
            text = f"{entry.instance}.{entry.port}: {error}"
            wrong.append(ROS_TOPIC.at(span, text, hint=error.hint))
    return wrong, marshaling(port.type, message, component.stamp, tuple(constants))


def _ports(running: runtime.System, instance: str) -> dict[str, Any]:
    component = running.component(instance)
    return {**component.in_ports, **component.out_ports}
