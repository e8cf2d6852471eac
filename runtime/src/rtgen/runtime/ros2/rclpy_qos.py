"""QoS events of rclpy, which are asked for: no callback, no place in a wait set."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any, Final

from rclpy.impl.implementation_singleton import rclpy_implementation

from rtgen.facts.ros_qos import Durability, Liveliness, Profile, Reliability
from rtgen.runtime.ros2.network import RosTopic
from rtgen.runtime.ros2.qos import Own, Peers

_MAX_PUBLISHERS: Final = 1024
"""Maximum number of publishers of a topic whose messages are counted."""
_LOOKS: Final = 5
"""How often ends of a topic are compared, one a second, after one was found that does not fit."""
_UNKNOWN: Final = "_NODE_NAME_UNKNOWN_"
"""What rmw says before it knows the node of an end (rmw_dds_common)."""
_READER = rclpy_implementation.rcl_subscription_event_type_t
_WRITER = rclpy_implementation.rcl_publisher_event_type_t
OF_SUBSCRIPTION: Final = {
    "unfit": _READER.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
    "deadline": _READER.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED,
    "liveliness": _READER.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,
}
OF_PUBLISHER: Final = {
    "unfit": _WRITER.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
    "deadline": _WRITER.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED,
    "liveliness": _WRITER.RCL_PUBLISHER_LIVELINESS_LOST,
}


class Status:
    """See `qos.End`: the events of an end, of which a middleware may have some only.

    `peers` compares ends, `others` returns rclpy's descriptions of those on the other side.
    """

    def __init__(
        self,
        handle: Any,
        types: Mapping[str, Any],
        own: Own,
        topic: RosTopic,
        peers: Peers,
        others: Callable[[], list[Any]],
    ) -> None:
        self._own = own
        self._topic = topic.name
        self._type_name = topic.type_name
        self._peers = peers
        self._others = others
        self._events: dict[str, Any] = {}
        self._totals = dict.fromkeys(types, 0)
        self._not_alive = 0
        self._looks = 0
        for name, type_ in types.items():
            try:
                with handle:
                    event = rclpy_implementation.EventHandle(handle, type_)
            except rclpy_implementation.UnsupportedEventTypeError:
                continue
            self._events[name] = event

    def total(self, name: str) -> int:
        """Return how often something happened."""
        event = self._events.get(name)
        if event is not None:
            with event:
                status = event.take_event()
            if status is not None:
                self._totals[name] = self._count(name, status)
        return self._totals[name]

    def _count(self, name: str, status: Any) -> int:
        if not hasattr(status, "not_alive_count"):
            return int(status.total_count)
        lost = max(status.not_alive_count - self._not_alive, 0)
        self._not_alive = status.not_alive_count
        return self._totals[name] + int(lost)

    def look(self) -> None:
        """See `qos.End`."""
        before = self._totals["unfit"]
        if self.total("unfit") != before:
            self._looks = _LOOKS
        if self._looks:
            self._looks -= 1
            for other in self._others():
                self._compare(other)

    def _compare(self, other: Any) -> None:
        """Compare another end of the topic, unless its QoS has values that rmw does not name.

        The name of its node may come later.
        """
        try:
            profile = _profile(other.qos_profile)
        except ValueError:
            return
        is_named = other.node_name != _UNKNOWN
        if other.topic_type == self._type_name and (is_named or not self._looks):
            name = f"{other.node_namespace.rstrip('/')}/{other.node_name}"
            node = name if is_named else None
            gid = bytes(other.endpoint_gid)
            self._peers.compare(self._topic, self._own, gid, profile, lambda: node)

    def close(self) -> None:
        """Ask no more; the totals stay."""
        events, self._events = self._events, {}
        for event in events.values():
            event.destroy_when_not_in_use()


class Gaps:
    """Counts the messages between those that are taken, by the numbers of their publishers."""

    def __init__(self, publishers: Callable[[], int]) -> None:
        self.lost = 0
        self._publishers = publishers
        self._last: OrderedDict[bytes, int] = OrderedDict()

    def count(self, info: Mapping[str, Any]) -> None:
        """Count what was lost before a message.

        Jazzy does not tell which publisher it is of: then the numbers of one are counted only.
        """
        number = info.get("publication_sequence_number")
        if number is None:
            return
        source = info.get("publisher_gid")
        gid = b"" if source is None else bytes(source["data"])
        last = self._last.get(gid)
        if last is not None and number <= last:
            if source is None:
                self._last[gid] = number
            return
        step = 1 if last is None else number - last
        if step > 1 and (source is not None or self._publishers() == 1):
            self.lost += step - 1
        self._last[gid] = number
        if len(self._last) > _MAX_PUBLISHERS:
            self._last.popitem(last=False)


def _profile(qos: Any) -> Profile:
    """Return what rclpy tells of the QoS of another end; policies have the same numbers."""

    def time(value: Any) -> int | None:
        return None if value.nanoseconds >= _ENDLESS else int(value.nanoseconds)

    return Profile(
        reliability=Reliability(qos.reliability),
        durability=Durability(qos.durability),
        deadline=time(qos.deadline),
        liveliness=Liveliness(qos.liveliness),
        lease=time(qos.liveliness_lease_duration),
    )


_ENDLESS: Final = (1 << 63) - 1
"""rmw's time for none."""
