"""Components as managed nodes with parameters: services and topics that tools of ROS 2 expect.

Each component is a node with its instance name, with `~/get_state` and others,
`~/transition_event`, `~/list_parameters` and others, and `/parameter_events`.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from rtgen.facts.ros_qos import PROFILES
from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.failures import log
from rtgen.runtime.return_codes import ERROR_STATE
from rtgen.runtime.ros2 import life_cycle, parameters
from rtgen.runtime.ros2.life_cycle import LifeCycle, Members
from rtgen.runtime.ros2.network import (
    Publish,
    Ros2Error,
    RosNetwork,
    RosService,
    RosTopic,
)
from rtgen.runtime.ros2.parameters import Parameters
from rtgen.runtime.ros2.services import Server
from rtgen.runtime.ros2.types import encoded, made
from rtgen.runtime.rtc.configuration import ACTIVE_SET
from rtgen.runtime.system.records import StateRecord
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import Event, LogLine, ParameterChange

EVENT_INFO: Final = "service_msgs/msg/ServiceEventInfo"
_TRANSITION_EVENT: Final = "lifecycle_msgs/msg/TransitionEvent"
_PARAMETER_EVENT: Final = "rcl_interfaces/msg/ParameterEvent"
_LOG: Final = "rcl_interfaces/msg/Log"
_LEVELS: Final = (10, 20, 30, 40, 50)
"""The levels of rcl_interfaces/msg/Log, which are those of `logging`, too."""
_SERVICES: Final = {
    **{
        name: f"lifecycle_msgs/srv/{type_}"
        for name, type_ in life_cycle.SERVICES.items()
    },
    **{
        name: f"rcl_interfaces/srv/{type_}"
        for name, type_ in parameters.SERVICES.items()
    },
}
INTERFACES: Final = tuple(
    dict.fromkeys(
        (
            *(EVENT_INFO, _TRANSITION_EVENT, _PARAMETER_EVENT, _LOG),
            *_SERVICES.values(),
        )
    )
)
"""The interfaces whose classes `ManagedNodes` requires."""
_TRANSITION_TIMEOUT: Final = 10.0
"""Time-out of a requested transition in seconds."""


class ManagedNodes:
    """Makes components of a system managed nodes, until `close`; the network stays open."""

    def __init__(
        self,
        network: RosNetwork,
        system: System,
        nodes: Mapping[str, str],
        classes: Mapping[str, type[Any]],
        namespace: str = "/",
        patience: float = _TRANSITION_TIMEOUT,
    ) -> None:
        """Initialize with the names of nodes by instance, and the classes of `INTERFACES`.

        Raises Ros2Error.
        """
        self._workers = Workers()
        self._nodes = {
            instance: _ManagedNode(
                f"{namespace.rstrip('/')}/{name}",
                LifeCycle(system, instance, patience),
                Parameters(system.component(instance).configuration_sets),
                system.clock.now,
            )
            for instance, name in nodes.items()
        }
        for node in self._nodes.values():
            node.join(network, classes, self._workers)
        self._closed = False
        system.watch_states(self._on_state)
        system.clock.traffic.watch(self._on_event)

    def close(self) -> None:
        """Stop responding."""
        self._closed = True
        for node in self._nodes.values():
            node.life_cycle.close()
        self._workers.close()

    def _on_state(self, record: StateRecord) -> None:
        node = self._nodes.get(record.instance)
        if node is not None and not self._closed:
            node.on_state(record)

    def _on_event(self, event: Event) -> None:
        if not isinstance(event, ParameterChange | LogLine) or self._closed:
            return
        node = self._nodes.get(event.instance)
        if node is None:
            return
        if isinstance(event, LogLine):
            node.on_line(event)
        else:
            node.on_parameter(event.parameter, event.value)


class _ManagedNode:
    """A component as a node with both groups of services."""

    def __init__(
        self,
        name: str,
        cycle: LifeCycle,
        values: Parameters,
        now: Callable[[], int],
    ) -> None:
        self._now = now
        self.life_cycle = cycle
        self._name = name
        self._parameters = values
        self._active_set = values.value(ACTIVE_SET)
        self._lock = threading.Lock()
        self._topics: dict[str, tuple[Publish, type[Any]]] = {}

    def join(
        self, network: RosNetwork, classes: Mapping[str, type[Any]], workers: Workers
    ) -> None:
        """Serve and publish. Raises Ros2Error."""
        node = self._name.rpartition("/")[2]
        for side, names in (
            (self.life_cycle, life_cycle.SERVICES),
            (self._parameters, parameters.SERVICES),
        ):
            _serve(network, classes, workers, self._name, side, names)
        for topic, type_, profile in (
            (f"{self._name}/transition_event", _TRANSITION_EVENT, "default"),
            ("/parameter_events", _PARAMETER_EVENT, "parameter_events"),
            ("/rosout", _LOG, "rosout"),
        ):
            shown = RosTopic(topic, classes[type_], node)
            publish = network.publisher(shown, PROFILES[profile])
            self._topics[type_] = publish, classes[type_]

    def on_state(self, record: StateRecord) -> None:
        """Publish a change of state."""
        event = self.life_cycle.changed(record)
        if event is not None:
            self._publish(_TRANSITION_EVENT, event)
        if record.after is ERROR_STATE:
            reason = record.reason or "ERROR"
            self.on_line(LogLine(record.instance, logging.ERROR, reason, "", "", 0))

    def on_line(self, line: LogLine) -> None:
        """Publish a line of the component's log."""
        levels = [level for level in _LEVELS if level <= line.level]
        message = {
            "stamp": self._stamp(),
            "level": max(levels, default=_LEVELS[0]),
            "name": self._name.strip("/").replace("/", "."),
            "msg": line.text,
            "file": line.file,
            "function": line.function,
            "line": line.line,
        }
        self._publish(_LOG, message)

    def _stamp(self) -> Members:
        seconds, rest = divmod(self._now(), SECOND)
        return {"sec": seconds, "nanosec": rest}

    def on_parameter(self, name: str, text: str) -> None:
        """Publish a parameter that has taken effect, and the active set with its first one."""
        changed = [{"name": name, "value": self._parameters.value(name, text)}]
        active = self._parameters.value(ACTIVE_SET)
        if active != self._active_set:
            self._active_set = active
            changed.append({"name": ACTIVE_SET, "value": active})
        event = {
            "stamp": self._stamp(),
            "node": self._name,
            "changed_parameters": changed,
        }
        self._publish(_PARAMETER_EVENT, event)

    def _publish(self, type_: str, members: Members) -> None:
        publish, class_ = self._topics[type_]
        try:
            octets = encoded(made(class_._descriptor_, members))
            with self._lock:
                publish(octets)
        except Ros2Error as error:
            log.warning("%s: %s", self._name, error)


def _serve(
    network: RosNetwork,
    classes: Mapping[str, type[Any]],
    workers: Workers,
    node: str,
    side: object,
    names: Iterable[str],
    queue: str | None = None,
) -> None:
    """Serve methods of an object as services of a node. Raises Ros2Error."""
    for name in names:
        type_ = _SERVICES[name]
        request, response = (
            classes[f"{type_}_{end}"] for end in ("Request", "Response")
        )
        service = RosService(
            *(request, response),
            f"{node}/{name}",
            classes[EVENT_INFO],
            node.rpartition("/")[2],
        )
        answer = _answering(getattr(side, name), response)
        queued = service.name if queue is None else queue
        network.serve(service, Server(service, answer, workers, queued).take)


class ParameterNodes:
    """Nodes with parameters alone, until `close`; the network stays open."""

    def __init__(
        self,
        network: RosNetwork,
        nodes: Mapping[str, object],
        classes: Mapping[str, type[Any]],
    ) -> None:
        """Initialize with the parameters of nodes by their qualified names. Raises Ros2Error.

        `classes` are those of `INTERFACES`. The requests of a node are served one by one.
        """
        self._workers = Workers()
        for node, values in nodes.items():
            names = parameters.SERVICES
            _serve(network, classes, self._workers, node, values, names, queue=node)

    def close(self) -> None:
        """Stop responding."""
        self._workers.close()


def _answering(
    answer: Callable[[Any], Members], response: type[Any]
) -> Callable[[Any], Any]:
    return lambda request: made(response._descriptor_, answer(request))
