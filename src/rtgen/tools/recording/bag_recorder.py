"""Records the topics of a run as a bag of ROS 2: messages sent, and those received from nodes."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rtgen.facts.ros_qos import Durability, Profile, Reliability
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.network import OnMessage, RosTopic
from rtgen.runtime.ros2.types import ros_name
from rtgen.runtime.system.system import System
from rtgen.tools.recording.bag_writer import BagWriter
from rtgen.tools.recording.recorder import clock_of

_MOST_EARLY = 10_000


@dataclass(slots=True)
class _Ends:
    """The ends of a topic in this process."""

    type: type[Any]
    offered: list[Profile] = field(default_factory=list)
    requested: list[Profile] = field(default_factory=list)


class BagRecorder:
    """An observer of a network (`RosNetwork.observe`) that writes the messages to a bag.

    Times are those of the clock: simulated from 0, real as UTC since 1970. A topic that components
    of the process both write and read has each message once. Hidden topics, such as those of
    actions, are left out, as by `ros2 bag record`.
    """

    def __init__(self, system: System, writer: BagWriter) -> None:
        self._system = system
        self._writer = writer
        self._ends: dict[str, _Ends] = {}
        self._announced: set[str] = set()
        self._early: deque[tuple[str, bytes]] | None = deque(maxlen=_MOST_EARLY)
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Write what has come. Call it when the run begins: its time is not known before."""
        with self._lock:
            self._writer.describe(clock_of(self._system))
            early, self._early = self._early or (), None
            for name, octets in early:
                self._write(name, octets)

    def observe(
        self, topic: RosTopic, profile: Profile, sent: bool
    ) -> OnMessage | None:
        """See `Observer`."""
        if is_hidden(topic.name):
            return None
        ends = self._ends.setdefault(topic.name, _Ends(topic.type))
        if ros_name(ends.type) != ros_name(topic.type):
            log.warning(
                "%s has messages of two types; the bag has those of %s",
                topic.name,
                ros_name(ends.type),
            )
            return None
        if sent:
            ends.offered.append(profile)
            return partial(self._sent, topic.name, profile)
        ends.requested.append(profile)
        return partial(self._received, topic.name, len(ends.requested) - 1)

    def close(self) -> None:
        """Announce the topics that had no message."""
        if self._early is not None:
            self.begin()
        for name in self._ends:
            self._announce(name)

    def _sent(self, name: str, profile: Profile, octets: bytes) -> None:
        if not any(_fit(profile, each) for each in self._ends[name].requested):
            self._put(name, octets)

    def _received(self, name: str, number: int, octets: bytes) -> None:
        # The one that gets most, of several on a topic.
        strictness = [*map(_strictness, self._ends[name].requested)]
        if number == strictness.index(min(strictness)):
            self._put(name, octets)

    def _put(self, name: str, octets: bytes) -> None:
        if self._early is not None:
            with self._lock:
                if self._early is not None:
                    self._early.append((name, octets))
                    return
        self._write(name, octets)

    def _write(self, name: str, octets: bytes) -> None:
        try:
            self._announce(name)
            self._writer.message(name, self._system.clock.now(), octets)
        except Exception as error:
            self._system.end_run(error)

    def _announce(self, name: str) -> None:
        if name not in self._announced:
            ends = self._ends[name]
            self._writer.topic(name, ends.type, ends.offered or ends.requested)
            self._announced.add(name)


def is_hidden(topic: str) -> bool:
    """Return whether `ros2 topic list` leaves out a topic: a word of its name begins with `_`."""
    return any(word.startswith("_") for word in topic.split("/"))


def _fit(offered: Profile, requested: Profile) -> bool:
    """Return whether a publisher's messages reach a subscription."""
    return _strictness(requested)[0] <= _strictness(offered)[0] and (
        _strictness(requested)[1] <= _strictness(offered)[1]
    )


def _strictness(profile: Profile) -> tuple[bool, bool]:
    return (
        profile.reliability is Reliability.RELIABLE,
        profile.durability is Durability.TRANSIENT_LOCAL,
    )
