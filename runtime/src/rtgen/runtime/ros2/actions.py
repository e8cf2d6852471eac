"""A service port as a ROS 2 action: three services and two topics below `NAME/_action/`.

The port has the two interfaces declared by an `.action` file. A server provides `Go` and uses
`Go_Events`, a client uses `Go` and may provide `Go_Events`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Final, TypeAlias, TypeVar

from rtgen.facts.ros import (
    ACTION_SERVICES,
    ACTION_TOPICS,
    EVENTS_SUFFIX,
    is_interface,
)
from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.ros2.network import RosService, RosTopic
from rtgen.runtime.ros2.services import (
    EventJoint,
    ServiceJoint,
    message_of,
    messages_of,
)
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.services.ports import Consumer, Provider
from rtgen.runtime.services.servants import ServiceError

_Port: TypeAlias = Provider[Any] | Consumer[Any]
_P = TypeVar("_P", bound=_Port)
_Q = TypeVar("_Q", bound=_Port)
_WAITS: Final = "get_result"
_PROFILES: Final = {
    "feedback": PROFILES["default"],
    "status": PROFILES["action_status"],
}


def joints_of(
    component: Component, port: str, action: str, event_info: type[Any], node: str = ""
) -> Iterator[ServiceJoint | EventJoint]:
    """Yield the services and topics that make a service port an action.

    The action's name is fully qualified. `event_info` and `node` are as in `RosService`. Raises
    ServiceError if it cannot be one.
    """
    goals, events = _ends(component, port)
    for operation in ACTION_SERVICES:
        messages = messages_of(goals.interface, operation)
        name = f"{action}/_action/{operation}"
        service = RosService(*messages, name, event_info, node)
        yield ServiceJoint(goals, operation, service, waits=operation == _WAITS)
    if events is not None:
        for operation in ACTION_TOPICS:
            message = message_of(events.interface, operation)
            topic = RosTopic(f"{action}/_action/{operation}", message, node)
            yield EventJoint(events, operation, topic, _PROFILES[operation])


def _ends(component: Component, name: str) -> tuple[_Port, _Port | None]:
    """Return the ends of the services and of the topics; a client may have none for topics."""
    whole = f"{component.instance_name}.{name}"
    every: list[_Port] = [
        *component.providers.values(),
        *component.consumers.values(),
    ]
    own = {_type(port): port for port in every if port.port == name}
    if not own:
        known = ", ".join(dict.fromkeys(port.port for port in every)) or "none"
        raise ServiceError(
            f"{component.instance_name} has no service port {name!r}; known: {known}"
        )
    goals = next(filter(_is_action, own), None)
    if goals is None:
        raise ServiceError(f"{whole} has no interface of an action: {', '.join(own)}")
    port, events = own[goals], own.get(goals + EVENTS_SUFFIX)
    serves = isinstance(port, Provider)
    if serves and not isinstance(events, Consumer):
        raise ServiceError(
            f"{whole} provides {goals}, but does not use {goals}{EVENTS_SUFFIX} in the same port"
        )
    if not serves and isinstance(events, Consumer):
        raise ServiceError(f"{whole} uses both {goals} and {goals}{EVENTS_SUFFIX}")
    for each in (port, events):
        if isinstance(each, Consumer) and each.connected:
            raise ServiceError(f"{whole} is connected in the system")
    return port, events


def ends_in(
    ones: Iterable[_P], others: Iterable[_Q], port: str
) -> tuple[_P, _Q | None] | None:
    """Return the end of an action's services in a port, and that of its topics, if it is there.

    None if the port has no action among `ones`.
    """
    for one in ones:
        if one.port == port and _is_action(_type(one)):
            events = f"{_type(one)}{EVENTS_SUFFIX}"
            fitting = (e for e in others if e.port == port and _type(e) == events)
            return one, next(fitting, None)
    return None


def _type(port: _Port) -> str:
    return str(port.interface._descriptor_.name)


def _is_action(name: str) -> bool:
    scoped = name.split("::")
    is_own = is_interface(scoped) and scoped[1] == "action"
    return is_own and not name.endswith(EVENTS_SUFFIX)
