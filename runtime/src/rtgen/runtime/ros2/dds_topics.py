"""Ends of topics on DDS: the history of a subscription, statuses of QoS, the peers of a topic."""

from __future__ import annotations

import ctypes
import threading
from collections import OrderedDict, defaultdict
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from cyclonedds import _clayer
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.domain import DomainParticipant
from cyclonedds.internal import dds_c_t
from cyclonedds.qos import _CQos
from cyclonedds.sub import DataReader

from rtgen.facts.ros_qos import (
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
)
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.medium import DdsPublisher, DdsSubscription
from rtgen.runtime.distribution.medium import MediumError, OnSample, Sample
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.ros2.qos import Own, Peers

_ROOM: Final = (8192, 1024, 128)
"""Samples that Cyclone keeps at least until they are taken, so that those beyond the depth of a
subscription can be counted: it does not count what it drops itself. The first number is for types
of a fixed size, the second for those with strings, the last for those with sequences, whose samples
may be large.
"""
_MAX_ENDS: Final = 8192
"""Maximum number of remembered readers and writers of other processes."""
_AT_ONCE: Final = 256
_FOREVER: Final = (1 << 63) - 1


def room(profile: Profile, type_: type[Any]) -> int:
    """Return the depth of the history of a Cyclone reader for a subscription with a profile."""
    return max(profile.depth, _ROOM[_growth(type_._descriptor_, set())])


def _growth(descriptor: Any, seen: set[str]) -> int:
    """Return the place of a type in `_ROOM`."""
    descriptor = plain(descriptor)
    match descriptor:
        case StringDescriptor():
            return 1
        case SequenceDescriptor():
            return 2
        case ArrayDescriptor(element=element):
            return _growth(element, seen)
        case StructDescriptor() if descriptor.name not in seen:
            seen.add(descriptor.name)
            return max((_growth(m.type, seen) for m in descriptor.members), default=0)
    return 0


class RosPublisher(DdsPublisher):
    """See `medium.Publisher` and `qos.End`."""

    @property
    def missed_deadlines(self) -> int:
        """See `qos.End`."""
        return _total(self._writer, "get_offered_deadline_missed_status", self._closed)

    @property
    def lost_liveliness(self) -> int:
        """See `qos.End`."""
        return _total(self._writer, "get_liveliness_lost_status", self._closed)

    def look(self) -> None:
        """See `qos.End`; `Discovery` reports peers."""


class RosSubscription(DdsSubscription):
    """See `medium.Subscription` and `qos.End`.

    `depth`: samples of each publisher that wait at most to be taken, None for all; older ones are
    dropped, and counted in `lost`.
    """

    def __init__(
        self,
        reader: DataReader[Any],
        dispatcher: Dispatcher,
        on_sample: OnSample,
        depth: int | None,
    ) -> None:
        self._depth = depth
        self._dropped = 0
        self._on_the_way = 0
        self._not_alive = 0
        self._lost_liveliness = 0
        super().__init__(reader, dispatcher, on_sample, are_numbered=False)

    @property
    def lost(self) -> int:
        """Samples that came too fast for the depth, or did not arrive."""
        on_the_way = _total(self._reader, "get_sample_lost_status", self._closed)
        self._on_the_way = max(self._on_the_way, on_the_way)
        return self._dropped + self._on_the_way

    @property
    def lost_liveliness(self) -> int:
        """See `qos.End`."""
        if not self._closed:
            reader: Any = self._reader
            now = int(reader.get_liveliness_changed_status().not_alive_count)
            self._lost_liveliness += max(now - self._not_alive, 0)
            self._not_alive = now
        return self._lost_liveliness

    def look(self) -> None:
        """See `qos.End`; `Discovery` reports peers."""

    def close(self) -> None:
        """See `medium.Subscription`."""
        self._on_the_way = self.lost - self._dropped
        super().close()

    def _take(self) -> None:
        samples = [each for each in entities.taken(self._reader) if each[1].valid_data]
        if self._depth is not None and len(samples) > self._depth:
            samples = self._newest(samples, self._depth)
        for octets, info in samples:
            handle = info.publication_handle
            source = self._writers.get(handle) or self._writer(handle)
            self._on_sample(Sample(octets, source))

    def _newest(
        self, samples: list[tuple[bytes, Any]], depth: int
    ) -> list[tuple[bytes, Any]]:
        """Return the samples that a history of this depth keeps; count the others."""
        count: defaultdict[int, int] = defaultdict(int)
        kept = []
        for sample in reversed(samples):
            writer = sample[1].publication_handle
            count[writer] += 1
            if count[writer] <= depth:
                kept.append(sample)
        self._dropped += len(samples) - len(kept)
        return kept[::-1]


def _total(end: Any, status: str, closed: bool) -> int:
    return 0 if closed else int(getattr(end, status)().total_count)


class _Endpoint(NamedTuple):
    """A reader or writer of any process."""

    type_name: str
    writes: bool
    profile: Profile


class Discovery:
    """Compares the ends of this process with those that DDS discovers on the same topics.

    `when_named` calls a function with the name of the node that has an end, once that is known.
    """

    def __init__(
        self,
        participant: DomainParticipant,
        dispatcher: Dispatcher,
        when_named: Callable[[bytes, Callable[[str | None], None]], None],
    ) -> None:
        self._when_named = when_named
        self._peers = Peers()
        self._lock = threading.Lock()
        self._known: OrderedDict[bytes, tuple[str, _Endpoint]] = OrderedDict()
        self._by_topic: defaultdict[str, dict[bytes, _Endpoint]] = defaultdict(dict)
        self._own: defaultdict[str, list[tuple[str, str, Own]]] = defaultdict(list)
        self._closing: list[Any] = []
        topics = (
            (BuiltinTopicDcpsPublication, True),
            (BuiltinTopicDcpsSubscription, False),
        )
        for topic, writes in topics:
            reader = BuiltinDataReader(participant, topic)
            condition = ReadCondition(
                reader, SampleState.Any | ViewState.Any | InstanceState.Any
            )
            entry = dispatcher.add(condition, _taking(self, reader, writes=writes))
            self._closing.append((entry, condition, reader))

    def add(self, topic: str, name: str, type_name: str, own: Own) -> None:
        """Compare an end of this process with those of its DDS topic; `name` is that of ROS."""
        with self._lock:
            self._own[topic].append((name, type_name, own))
            others = {**self._by_topic[topic]}
        for guid, other in others.items():
            self._compare(name, type_name, own, guid, other)

    def close(self) -> None:
        """Discover no more."""
        closing, self._closing = self._closing, []
        for entry, condition, reader in closing:
            entry.close()
            entities.delete(condition)
            entities.delete(reader)

    def found(self, guid: bytes, topic: str, endpoint: _Endpoint) -> None:
        """Process a reader or writer that was discovered."""
        with self._lock:
            self._known[guid] = topic, endpoint
            self._by_topic[topic][guid] = endpoint
            if len(self._known) > _MAX_ENDS:
                self._forget(next(iter(self._known)))
            own = [*self._own.get(topic, ())]
        for name, type_name, end in own:
            self._compare(name, type_name, end, guid, endpoint)

    def gone(self, guid: bytes) -> None:
        """Process a reader or writer that is no more."""
        with self._lock:
            if guid in self._known:
                self._forget(guid)

    def _forget(self, guid: bytes) -> None:
        topic, _ = self._known.pop(guid)
        self._by_topic[topic].pop(guid, None)
        if not self._by_topic[topic]:
            del self._by_topic[topic]

    def _compare(
        self, name: str, type_name: str, own: Own, guid: bytes, other: _Endpoint
    ) -> None:
        if own.writes is other.writes or type_name != other.type_name:
            return

        def compare(node: str | None) -> None:
            self._peers.compare(name, own, guid, other.profile, lambda: node)

        if own.misfits(other.profile):
            self._when_named(guid, compare)


def _taking(
    discovery: Discovery, reader: BuiltinDataReader, *, writes: bool
) -> Callable[[], None]:
    def take() -> None:
        while True:
            found = _clayer.ddspy_take_endpoint(
                reader._ref, _AT_ONCE, _described, _profile
            )
            if isinstance(found, int):
                raise MediumError("discovered readers and writers cannot be taken")
            for guid, topic, type_name, profile, is_alive in found:
                if is_alive:
                    endpoint = _Endpoint(type_name, writes, profile)
                    discovery.found(guid, topic, endpoint)
                else:
                    discovery.gone(guid)
            if len(found) < _AT_ONCE:
                return

    return take


def _described(guid: bytes, *described: Any) -> tuple[bytes, str, str, Profile, bool]:
    """Return a reader or writer from cyclonedds's values."""
    _, _, topic, type_name, profile, info, _ = described
    is_alive = info.valid_data and info.instance_state == InstanceState.Alive
    return guid, topic, type_name, profile, is_alive


_DURABILITIES: Final = (
    *(Durability.VOLATILE, Durability.TRANSIENT_LOCAL),
    *(Durability.TRANSIENT, Durability.PERSISTENT),
)
"""By the numbers of `dds_durability_kind_t`; livelinesses follow their own in the same way."""
_LIVELINESSES: Final = tuple(Liveliness)


def _profile(pointer: int) -> Profile:
    """Return the profile of a QoS of C; policies that are not told have DDS's defaults.

    cyclonedds's own conversion uses variables shared by all threads.
    """
    qos = ctypes.cast(pointer, dds_c_t.qos_p)
    kind, time = ctypes.c_int(), ctypes.c_int64()
    depth = ctypes.c_int32()
    values: dict[str, Any] = {}
    if _CQos._get_reliability(qos, _ref(kind), _ref(time)):
        is_reliable = kind.value == 1
        values["reliability"] = (
            Reliability.RELIABLE if is_reliable else Reliability.BEST_EFFORT
        )
    if _CQos._get_durability(qos, _ref(kind)):
        values["durability"] = _DURABILITIES[kind.value]
    if _CQos._get_deadline(qos, _ref(time)):
        values["deadline"] = _finite(time)
    if _CQos._get_liveliness(qos, _ref(kind), _ref(time)):
        values["liveliness"] = _LIVELINESSES[kind.value]
        values["lease"] = _finite(time)
    if _CQos._get_history(qos, _ref(kind), _ref(depth)) and kind.value == 1:
        values["history"] = History.KEEP_ALL
    return Profile(**values)


def _ref(variable: Any) -> Any:
    return ctypes.byref(variable)


def _finite(time: ctypes.c_int64) -> int | None:
    return None if time.value == _FOREVER else time.value
