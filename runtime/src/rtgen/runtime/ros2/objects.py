"""Objects of CANopen devices in ROS 2: topics of the samples of proxies, parameters by SDO."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final

import msgspec

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.canopen.description import ObjectNumber, ObjectValue
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.hooks import ProxyHooks
from rtgen.runtime.canopen.pdo import unscaled
from rtgen.runtime.canopen.wire.sdo import SdoAbort
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.failures import log
from rtgen.runtime.ports.data_ports import DataConnector, InPort, OutPort
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.ros2.life_cycle import Members
from rtgen.runtime.ros2.network import (
    Publish,
    Ros2Error,
    RosNetwork,
    RosTopic,
)
from rtgen.runtime.ros2.parameters import (
    ACCEPTED,
    Kind,
    bounded,
    is_listed,
    kind_name,
    range_of,
    value_member,
)
from rtgen.runtime.ros2.types import decoded, encoded, made

_TIMES: Final = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_PROFILE: Final = PROFILES["default"]
_SECOND: Final = 1_000_000_000


class ObjectJoint(msgspec.Struct, frozen=True):
    """An object as a topic: ports of the proxy, each with the member of its samples.

    `start` is the value that the device begins with; None for that of its type.
    """

    topic: RosTopic
    ports: tuple[tuple[InPort[Any] | OutPort[Any], str], ...]
    start: ObjectValue | None = None


class ObjectTopics:
    """The topics of a proxy's ports, until `close`."""

    def __init__(
        self,
        network: RosNetwork,
        joints: Iterable[ObjectJoint],
        stamp: Callable[[Any], None],
    ) -> None:
        """Publish and subscribe; `stamp` sets the time of samples. Raises Ros2Error."""
        self._outlets: dict[int, _Outlet] = {}
        self._inlets: dict[int, _Inlet] = {}
        for joint in joints:
            for port, member in joint.ports:
                if isinstance(port, OutPort):
                    outlet = self._outlets.get(id(port)) or _Outlet(port)
                    self._outlets[id(port)] = outlet
                    publish = network.publisher(joint.topic, _PROFILE)
                    outlet.add(joint.topic, _attribute(port, member), publish)
                    continue
                inlet = self._inlets.get(id(port)) or _Inlet(port, joint.topic, stamp)
                self._inlets[id(port)] = inlet
                attribute = _attribute(port, member)
                if joint.start is not None:
                    inlet.start({attribute: joint.start})
                take = partial(inlet.take, joint.topic, attribute)
                network.subscribe(joint.topic, _PROFILE, take)

    def close(self) -> None:
        """Stop publishing and receiving."""
        for outlet in self._outlets.values():
            outlet.close()
        for inlet in self._inlets.values():
            inlet.close()


def _attribute(port: InPort[Any] | OutPort[Any], member: str) -> str:
    """Return the attribute of a member of a port's samples."""
    members = port.type._descriptor_.members
    attribute: str = next(m.attribute for m in members if m.name == member)
    return attribute


class _Outlet:
    """Publishes the members of the samples of an OutPort."""

    def __init__(self, port: OutPort[Any]) -> None:
        self._port = port
        self._topics: list[tuple[RosTopic, str, Publish]] = []
        port.add_outlet(self._send)

    def add(self, topic: RosTopic, attribute: str, publish: Publish) -> None:
        """Publish a member on a topic."""
        self._topics.append((topic, attribute, publish))

    def _send(self, sample: Any) -> PortStatus:
        status = PORT_OK
        for topic, attribute, publish in self._topics:
            try:
                publish(encoded(to_message(topic, getattr(sample, attribute))))
            except (CdrError, Ros2Error, ValueError) as error:
                log.warning("%s: %s", topic.name, error)
                status = PortStatus.PORT_ERROR
        return status

    def close(self) -> None:
        """Stop publishing."""
        self._port.remove_outlet(self._send)


class _Inlet:
    """Writes samples to an InPort, with the last value of each member."""

    def __init__(
        self, port: InPort[Any], topic: RosTopic, stamp: Callable[[Any], None]
    ) -> None:
        self._lock = threading.Lock()
        self._values: dict[str, Any] = {}
        self._stamp = stamp
        outside: OutPort[Any] = OutPort("topic", port.type, topic.name.strip("/"))
        self._connector = DataConnector(
            topic.name, outside, port, {}, lambda: port._guard
        )
        self._connector.attach()

    def take(self, topic: RosTopic, attribute: str, octets: bytes) -> None:
        """Write a sample with the value of a message."""
        port = self._connector.target
        try:
            message = decoded(topic.type, octets)
            with self._lock:
                sample = port.type()
                value = of_message(topic, message, getattr(sample, attribute))
                values = {**self._values, attribute: value}
                for name, each in values.items():
                    setattr(sample, name, each)
                self._stamp(sample)
                sample.to_cdr(True)  # raises CdrError for values out of range
                self._values = values
        except (CdrError, ValueError) as error:
            log.warning("%s: a message is left out: %s", topic.name, error)
            return
        self._connector.give(sample)

    def start(self, values: Mapping[str, Any]) -> None:
        """Set the values of members before the first message."""
        self._values = {**values, **self._values}

    def close(self) -> None:
        """Stop receiving."""
        self._connector.detach()


def to_message(topic: RosTopic, value: Any) -> Any:
    """Return the message with the value of an object, as samples of proxies have it."""
    descriptor = topic.type._descriptor_
    if topic.type_name in _TIMES:
        return made(descriptor, {"sec": value.sec, "nanosec": value.nsec})
    if topic.type_name == "std_msgs/msg/Char":
        value = ord(value)
    return made(descriptor, {"data": value})


def of_message(topic: RosTopic, message: Any, former: Any) -> Any:
    """Return the value of a message; a time has the type of the former one."""
    if topic.type_name in _TIMES:
        return type(former)(message.sec, message.nanosec)
    if topic.type_name == "std_msgs/msg/Char":
        return chr(message.data)
    return message.data


class ObjectProfile(msgspec.Struct, frozen=True, kw_only=True):
    """An object that is a parameter; `low` and `high` are its range, with the factor applied."""

    name: str
    number: ObjectNumber
    kind: str
    factor: float | None = None
    readable: bool = True
    writable: bool = True
    low: float | None = None
    high: float | None = None
    description: str = ""

    @property
    def type(self) -> Kind:
        """The type of the parameter."""
        if self.factor is not None or self.kind in ("r32", "r64"):
            return Kind.DOUBLE
        if self.kind in ("char", "string", "wstring"):
            return Kind.STRING
        return {"bool": Kind.BOOL, "octets": Kind.BYTE_ARRAY}.get(
            self.kind, Kind.STRING if self.kind == "u64" else Kind.INTEGER
        )

    def admits(self, value: Any) -> bool:
        """Return whether a number is within the range; other values are."""
        if not isinstance(value, int | float) or isinstance(value, bool):
            return True
        return (self.low is None or value >= self.low) and (
            self.high is None or value <= self.high
        )


class ObjectParameters:
    """Implements the parameter services of a device: values are read and written by SDO.

    ROS 2 has no errors of `get_parameters`: a value that cannot be read is NOT_SET, and the log
    says why.
    """

    def __init__(self, proxy: ProxyHooks, profiles: Sequence[ObjectProfile]) -> None:
        self._proxy = proxy
        self._profiles = {profile.name: profile for profile in profiles}

    def list_parameters(self, request: Any) -> Members:
        """Return the names at or below the prefixes."""
        bounded(request.prefixes)
        names = [name for name in self._profiles if is_listed(name, request)]
        return {"result": {"names": names, "prefixes": []}}

    def get_parameters(self, request: Any) -> Members:
        """Return the values; NOT_SET for unknown names, and objects that cannot be read."""
        return {"values": [self._read(name) for name in bounded(request.names)]}

    def get_parameter_types(self, request: Any) -> Members:
        """Return the types; NOT_SET for unknown names."""
        return {"types": bytes(self._type(n) for n in bounded(request.names))}

    def describe_parameters(self, request: Any) -> Members:
        """Return the descriptors; for unknown names those of a parameter that is not set."""
        return {"descriptors": [self._descriptor(n) for n in bounded(request.names)]}

    def set_parameters(self, request: Any) -> Members:
        """Write objects one by one."""
        return {"results": [self._set([each]) for each in bounded(request.parameters)]}

    def set_parameters_atomically(self, request: Any) -> Members:
        """Write objects in order until one is refused: a device writes one at a time."""
        return {"result": self._set(bounded(request.parameters))}

    def _type(self, name: str) -> Kind:
        profile = self._profiles.get(name)
        return Kind.NOT_SET if profile is None else profile.type

    def _read(self, name: str) -> Members:
        profile = self._profiles.get(name)
        if profile is None or not profile.readable:
            return {"type": Kind.NOT_SET}
        try:
            value: Any = self._proxy.read_object(*profile.number)
        except (SdoAbort, LinkError, ValueError) as error:
            log.warning("parameter %s cannot be read: %s", name, error)
            return {"type": Kind.NOT_SET}
        if profile.factor is not None:
            value = float(value * profile.factor)
        kind = profile.type
        shown = str(value) if kind is Kind.STRING else value
        return {"type": kind, value_member(kind): shown}

    def _descriptor(self, name: str) -> Members:
        profile = self._profiles.get(name)
        if profile is None:
            return {"name": name, "type": Kind.NOT_SET}
        return {
            "name": name,
            "type": profile.type,
            "description": profile.description,
            "read_only": not profile.writable,
            **(
                range_of(profile.type, profile.low, profile.high)
                if profile.type in (Kind.INTEGER, Kind.DOUBLE)
                else {}
            ),
        }

    def _set(self, parameters: Sequence[Any]) -> Members:
        written: list[str] = []
        try:
            for profile, value in [*self._checked(parameters)]:
                try:
                    self._proxy.write_object(*profile.number, value)
                except (SdoAbort, LinkError, ValueError) as error:
                    before = (
                        f"; written before: {', '.join(written)}" if written else ""
                    )
                    raise ValueError(f"{profile.name}: {error}{before}") from error
                written.append(profile.name)
        except ValueError as error:
            return {"successful": False, "reason": str(error)}
        return {"successful": True}

    def _checked(
        self, parameters: Iterable[Any]
    ) -> Iterator[tuple[ObjectProfile, ObjectValue]]:
        """Yield the objects with values of their types. Raises ValueError."""
        for parameter in parameters:
            profile = self._profiles.get(parameter.name)
            if profile is None:
                raise ValueError(f"there is no parameter {parameter.name!r}")
            if not profile.writable:
                raise ValueError(f"{profile.name} is read-only")
            given, expected = parameter.value.type, profile.type
            if given != expected and given not in ACCEPTED.get(expected, ()):
                raise ValueError(
                    f"parameter {profile.name!r} is of type {kind_name(expected)}, not "
                    f"{kind_name(given)}"
                )
            value = getattr(parameter.value, value_member(Kind(given)))
            if not profile.admits(value):
                ends = f"{profile.low} to {profile.high}"
                raise ValueError(f"{profile.name} is {value}, not within {ends}")
            yield profile, _raw(profile, value)


def _raw(profile: ObjectProfile, value: Any) -> ObjectValue:
    """Return the value on the wire. Raises ValueError."""
    if profile.factor is not None and profile.kind in ("r32", "r64"):
        return float(value / profile.factor)
    if profile.factor is not None:
        return unscaled(profile.name, value, profile.factor)
    if profile.kind == "octets":
        return bytes(value)
    if profile.kind == "u64":
        return int(value)
    raw: ObjectValue = value
    return raw
