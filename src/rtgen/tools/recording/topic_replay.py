"""Replays a bag of ROS 2 into a system: its messages reach the ports that are bound to topics.

In simulated time a message arrives at its time in the bag, after the ticks of that instant, so two
replays are equal.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from rtgen.facts.ros_names import parse_type
from rtgen.runtime import System
from rtgen.runtime.distribution.medium import (
    Client,
    MediumError,
    OnRequest,
    OnSample,
    Qos,
    Sample,
    Token,
)
from rtgen.runtime.ros2.network import RosQos, RosService, RosTopic
from rtgen.runtime.ros2.types import ros_name, type_hash
from rtgen.runtime.system.simulated_time import SimulatedScheduler
from rtgen.runtime.timing.clocks import SECOND, SimulatedClock
from rtgen.tools.recording.bag_files import Recording, start_of
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.mcap_reader import Channel, Message
from rtgen.tools.recording.ros_messages import ENCODINGS
from rtgen.tools.recording.schema_types import type_of

_HASH: Final = "RIHS01_"
_LATEST: Final = (1 << 32) * SECOND
"""The first time [ns] that a message's stamp cannot hold."""
_LONGEST: Final = 366 * 24 * 3600 * SECOND
"""Longest replay without an end [ns]; a wrong time would make it last for years."""


@dataclass(slots=True)
class Survey:
    """The topics of a bag with their channels; its start, and the last message's time [ns]."""

    bag: Recording
    channels: dict[str, list[Channel]] = field(default_factory=dict)
    start: int = 0
    end: int = 0
    is_ordered: bool = True


def survey(bag: Recording) -> Survey:
    """Read through a bag. Raises RecordingError, also for one without messages."""
    found = Survey(bag)
    first, last = None, 0
    for message in bag.messages():
        time, channel = message.time, message.channel
        known = found.channels.setdefault(channel.topic, [])
        if channel not in known:
            known.append(channel)
        if first is not None and time < last:
            found.is_ordered = False
        first = time if first is None else min(first, time)
        last = max(last, time)
    if first is None:
        raise RecordingError(f"{bag.path} has no messages")
    if not 0 <= first <= last < _LATEST:
        wrong = first if first < 0 else last
        raise RecordingError(f"{bag.path}: {wrong} ns is not a time since 1970")
    found.start, found.end = min(first, start_of(bag)), last
    return found


class LocalMedium:
    """The topics of a system that is replayed; see `medium.Messaging`. It has no services."""

    def __init__(self) -> None:
        self.subscriptions: dict[str, list[_Subscription]] = {}
        self.written: set[str] = set()
        """Topics that components of the system publish."""

    def publisher(self, topic: RosTopic, qos: RosQos) -> _Publisher:
        """See `Messaging`."""
        self.written.add(topic.name)
        return _Publisher(self, topic.name, qos)

    def subscribe(
        self, topic: RosTopic, qos: RosQos, on_sample: OnSample
    ) -> _Subscription:
        """See `Messaging`."""
        made = _Subscription(qos, on_sample)
        self.subscriptions.setdefault(topic.name, []).append(made)
        return made

    def serve(
        self, service: str, types: Sequence[RosService], on_request: OnRequest
    ) -> Token:
        """Raise MediumError."""
        raise MediumError(f"{service}: services are not replayed")

    def client(self, service: str, types: RosService) -> Client:
        """Raise MediumError."""
        raise MediumError(f"{service}: services are not replayed")

    def deliver(self, topic: str, octets: bytes, offered: Qos | None = None) -> None:
        """Deliver a message to the subscriptions of a topic, if they take an offered QoS."""
        for each in self.subscriptions.get(topic, ()):
            if offered is None or (
                offered.reliable >= each.qos.reliable
                and offered.durable >= each.qos.durable
            ):
                each.on_sample(Sample(octets, topic))

    def close(self) -> None:
        """See `Messaging`."""
        self.subscriptions.clear()


@dataclass(frozen=True, slots=True)
class _Subscription:
    qos: Qos
    on_sample: OnSample
    lost: int = 0
    missed_deadlines: int = 0

    def close(self) -> None:
        """See `medium.Subscription`."""


@dataclass(frozen=True, slots=True)
class _Publisher:
    medium: LocalMedium
    topic: str
    qos: Qos
    matched: bool = True

    def publish(self, octets: bytes) -> None:
        """See `medium.Publisher`."""
        self.medium.deliver(self.topic, octets, self.qos)

    def close(self) -> None:
        """See `medium.Publisher`."""


class TopicReplay:
    """Replays topics of a bag into a system in simulated time, whose clock begins at its start."""

    def __init__(
        self,
        surveyed: Survey,
        topics: Mapping[str, type[Any]],
        deliver: Callable[[str, bytes], None],
    ) -> None:
        """Check the types of the topics, by names of the bag. Raises RecordingError."""
        self._survey = surveyed
        self._deliver = deliver
        for name, type_ in topics.items():
            for channel in surveyed.channels[name]:
                _check(surveyed.bag, channel, type_)
        self._messages = self._ordered(frozenset(topics))

    def run(self, system: System, until: int | None = None) -> None:
        """Run to the last message of the bag, or until an earlier time [ns]."""
        end = self._survey.end - self._survey.start
        if until is None and end > _LONGEST:
            raise RecordingError(
                f"{self._survey.bag.path} has messages of {end / SECOND:.0f} s",
                hint="--until ends the replay before",
            )
        self._schedule(system, next(self._messages, None))
        if until is not None and until < end:
            system.run(until)
            return
        system.at(end, lambda: None)
        system.run(until=lambda system: system.time >= end)

    def _schedule(self, system: System, message: Message | None) -> None:
        """Schedule a message, and the following ones at the same time."""
        if message is None:
            return
        clock = system.clock
        assert isinstance(clock, SimulatedClock)
        assert isinstance(clock.instants, SimulatedScheduler)
        later = clock.instants.after_ticks

        def write() -> None:
            following: Message | None = message
            while following is not None and following.time == message.time:
                self._deliver(following.channel.topic, following.data)
                following = next(self._messages, None)
            self._schedule(system, following)

        system.at(message.time - self._survey.start, lambda: later(write))

    def _ordered(self, topics: Collection[str]) -> Iterator[Message]:
        """Yield the messages of topics in the order of their times."""
        chosen = (m for m in self._survey.bag.messages() if m.channel.topic in topics)
        if self._survey.is_ordered:
            return chosen
        return iter(sorted(chosen, key=lambda message: message.time))


def _check(bag: Recording, channel: Channel, type_: type[Any]) -> None:
    """Raise RecordingError unless a channel has serialized messages of a class."""
    where = f"{bag.path}: {channel.topic}"
    schema, title = channel.schema, ros_name(type_)
    if channel.encoding != "cdr" or schema.encoding not in ENCODINGS:
        raise RecordingError(
            f"{where}: messages are {channel.encoding or 'of no encoding'}"
            f" with schemas {schema.encoding or 'of none'}, not those of ROS 2"
        )
    recorded = parse_type(schema.name)
    if recorded != title:
        raise RecordingError(
            f"{where} has messages of {schema.name}; the port's are {title}"
        )
    recorded_hash = channel.get("topic_type_hash")
    try:
        if not recorded_hash.startswith(_HASH):
            if not schema.encoding:
                return  # a bag of Humble says no more than the name
            recorded_hash = type_hash(type_of(schema))
        is_equal = recorded_hash == type_hash(type_)
    except ValueError:
        return  # a type that ROS 2 has no hash of
    if not is_equal:
        raise RecordingError(
            f"{where} has messages of another definition of {title}",
            hint=f"rtgen log cat {bag.path} {channel.topic} shows them",
        )
