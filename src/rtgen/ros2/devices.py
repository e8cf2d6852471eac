"""Nodes of CANopen buses in ROS 2: objects mapped to PDOs are topics, all others parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

import msgspec

from rtgen.compiler.model import Model
from rtgen.compiler.model.can_bus import Bus, BusNode
from rtgen.compiler.model.canopen import PdoDirection, Variable, resolved
from rtgen.compiler.typemap.canopen.idl import limits
from rtgen.compiler.typemap.canopen.labels import line
from rtgen.compiler.typemap.canopen.names import numbered
from rtgen.compiler.typemap.canopen.ports import (
    NUMERIC,
    DevicePorts,
    ObjectPort,
    Quantity,
)
from rtgen.compiler.typemap.canopen.values import kind
from rtgen.facts import ros_names
from rtgen.ros2.backend.fields import field_name

_MESSAGES: Final[Mapping[str, str]] = {
    "bool": "std_msgs/msg/Bool",
    "char": "std_msgs/msg/Char",
    "string": "std_msgs/msg/String",
    "wstring": "std_msgs/msg/String",
    "octets": "std_msgs/msg/UInt8MultiArray",
    "time_of_day": "builtin_interfaces/msg/Time",
    "time_difference": "builtin_interfaces/msg/Duration",
    "r32": "std_msgs/msg/Float32",
    "r64": "std_msgs/msg/Float64",
}
_WIDTHS: Final = (8, 16, 32, 64)


class ObjectTopic(msgspec.Struct, frozen=True):
    """An object mapped to PDOs as a topic; `sent`: by the device.

    `name` is below the node, `places` are ports of the proxy with the member of their samples;
    `start` is the number that the node begins with.
    """

    name: str
    message: str
    quantity: Quantity
    sent: bool
    places: tuple[tuple[str, str], ...]
    start: bool | float | None = None


class ObjectParameter(msgspec.Struct, frozen=True):
    """An object that no PDO maps, as a parameter with its range (`low`, `high`)."""

    name: str
    quantity: Quantity
    kind: str
    low: float | None
    high: float | None


class RosDevice(msgspec.Struct, frozen=True):
    """A node of a bus as a node of ROS 2."""

    bus: Bus
    node: BusNode
    name: str
    topics: tuple[ObjectTopic, ...]
    parameters: tuple[ObjectParameter, ...]

    @property
    def proxy(self) -> str:
        """The type of its proxy."""
        return f"{self.node.kind.module}Proxy"


def devices(model: Model) -> list[RosDevice]:
    """Return the nodes of all buses; one has the name of its bus, too, if another has its name."""
    names = Counter(field_name(n.name) for bus in model.buses for n in bus.nodes)
    return [
        _device(
            bus, node, field_name(node.name), alone=names[field_name(node.name)] == 1
        )
        for bus in model.buses
        for node in bus.nodes
    ]


def device_facts(
    nodes: Iterable[RosDevice], namespace: str
) -> Iterator[dict[str, str | list[dict[str, str]]]]:
    """Yield the topics and parameters of each node, as `rtgen inspect` shows them."""
    for node in nodes:
        yield {
            "node": ros_names.qualified(node.name, namespace),
            "topics": [
                {
                    "name": ros_names.qualified(f"{node.name}/{t.name}", namespace),
                    "type": t.message,
                    "direction": "publishes" if t.sent else "subscribes",
                    "object": _number(t.quantity.variable),
                }
                for t in node.topics
            ],
            "parameters": [
                {"name": p.name, "object": _number(p.quantity.variable)}
                for p in node.parameters
            ],
        }


def _number(variable: Variable) -> str:
    return f"{variable.index:04X}:{variable.subindex}"


def _device(bus: Bus, node: BusNode, own: str, *, alone: bool) -> RosDevice:
    ports = DevicePorts(node.kind.device, node.kind)
    mapped = {f.variable.number for s in ports.samples for f in s.fields}
    quantities = [
        ports.quantity(variable)
        for variable in ports.device.variables
        if variable.number not in mapped
    ]
    names = _names(ports)
    return RosDevice(
        bus,
        node,
        own if alone else field_name(f"{bus.name}_{node.name}"),
        tuple(_topic(ports, port, names, node.id) for port in ports.object_ports),
        tuple(_parameter(node, quantity, names) for quantity in quantities),
    )


def _names(ports: DevicePorts) -> dict[tuple[int, int], str]:
    """Return the names of all objects; the number is appended to those that are equal."""
    plain = {number: field_name(name) for number, name in ports.names.items()}
    counts = Counter(plain.values())
    return {
        number: name if counts[name] == 1 else numbered(name, number).lower()
        for number, name in plain.items()
    }


def _topic(
    ports: DevicePorts,
    port: ObjectPort,
    names: Mapping[tuple[int, int], str],
    node_id: int,
) -> ObjectTopic:
    variable = port.quantity.variable
    name = names[variable.index, variable.subindex]
    plain = ports.names[variable.index, variable.subindex]
    samples = {(s.pdo.direction, s.pdo.number): s for s in ports.samples}
    if ports.per_object:
        places = [(port.name, "data")]
    else:
        of = [(samples[port.direction, pdo], place) for pdo, place in port.places]
        places = [(sample.name, sample.fields[place].name) for sample, place in of]
    return ObjectTopic(
        name + port.name.removeprefix(plain),
        message_of(port.quantity),
        port.quantity,
        port.direction is PdoDirection.TPDO,
        tuple(places),
        _start(port.quantity, node_id),
    )


def _start(quantity: Quantity, node_id: int) -> bool | float | None:
    variable = quantity.variable
    value = resolved(variable.start(node_id), node_id)
    if not isinstance(value, int | float) or variable.data_type not in NUMERIC:
        return None
    return value if quantity.factor is None else value * quantity.factor


def message_of(quantity: Quantity) -> str:
    """Return the message of an object's values; of physical ones `std_msgs/msg/Float64`."""
    if quantity.factor is not None:
        return _MESSAGES["r64"]
    own = kind(quantity.variable.data_type)
    if own in _MESSAGES:
        return _MESSAGES[own]
    width = next(each for each in _WIDTHS if each >= int(own[1:]))
    return f"std_msgs/msg/{'U' if own[0] == 'u' else ''}Int{width}"


def _parameter(
    node: BusNode, quantity: Quantity, names: Mapping[tuple[int, int], str]
) -> ObjectParameter:
    variable = quantity.variable
    own = kind(variable.data_type)
    low = high = None
    if variable.data_type in NUMERIC:
        natural = limits(variable.data_type) or (None, None)
        ends = [
            _scaled(resolved(limit, node.id), natural_end, quantity.factor)
            for limit, natural_end in zip(
                (variable.low, variable.high), natural, strict=True
            )
        ]
        low, high = ends if (quantity.factor or 1) > 0 else ends[::-1]
    name = names[variable.index, variable.subindex]
    return ObjectParameter(name, quantity, own, low, high)


def _scaled(limit: object, natural: float | None, factor: float | None) -> float | None:
    value = limit if isinstance(limit, int | float) else natural
    return value if value is None or factor is None else value * factor


def description(parameter: ObjectParameter) -> str:
    """Return the description of a parameter: its object, and the unit."""
    quantity = parameter.quantity
    unit = line(quantity.unit)
    text = f"{line(quantity.variable.name)} ({_number(quantity.variable)})"
    return f"{text} [{unit}]" if unit else text
