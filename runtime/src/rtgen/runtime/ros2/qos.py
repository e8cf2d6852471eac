"""QoS during a run: peers that do not fit, missed deadlines, publishers without a sign of life."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from typing import Final, Protocol, runtime_checkable

import msgspec

from rtgen.facts.ros_qos import Misfit, Profile, change, misfits, seconds, values_of
from rtgen.runtime.failures import log

_INTERVAL: Final = 1.0
"""Seconds between looks at the ends."""
_QUIET: Final = 10.0
"""Seconds between two reports of one kind about one end."""
_MAX_REPORTS: Final = 1024


class Peers:
    """Reports each pair of ends whose QoS does not fit, once.

    `delivers`: the network passes messages on all the same, as Zenoh does.
    """

    def __init__(self, *, delivers: bool = False) -> None:
        self._delivers = delivers
        self._lock = threading.Lock()
        self._reported: set[frozenset[Hashable]] = set()

    def compare(
        self,
        topic: str,
        own: Own,
        other: Hashable,
        profile: Profile,
        node: Callable[[], str | None],
    ) -> None:
        """Compare an end of this process with another end of its topic, with that one's profile.

        `other` identifies it; `node` returns the name of its node, None if that is not known.
        """
        unfit = own.misfits(profile)
        if not unfit:
            return
        pair = frozenset((own.id, other))
        with self._lock:
            if pair in self._reported or len(self._reported) >= _MAX_REPORTS:
                return
            self._reported.add(pair)
        name = node()
        there = f"node {name}" if name is not None else "a program without node"
        ends = f"node {own.node}", there
        publisher, subscription = ends if own.writes else ends[::-1]
        log.warning(
            "%s: the subscription of %s asks for more than the publisher of %s offers, so it %s: "
            "%s; %s",
            topic,
            subscription,
            publisher,
            "would get nothing over DDS" if self._delivers else "gets nothing",
            values_of(unfit),
            change(unfit, writes=own.writes),
        )


class Own(msgspec.Struct, frozen=True):
    """An end of this process: its identity, qualified node and profile; a publisher `writes`."""

    id: Hashable
    node: str
    profile: Profile
    writes: bool

    def misfits(self, profile: Profile) -> list[Misfit]:
        """Return the policies that do not fit those of another end."""
        ends = self.profile, profile
        return misfits(*(ends if self.writes else ends[::-1]))


@runtime_checkable
class End(Protocol):
    """What is watched: counts since it was made."""

    @property
    def missed_deadlines(self) -> int:
        """How many periods of the deadline passed without a sample."""

    @property
    def lost_liveliness(self) -> int:
        """How often a publisher showed no sign of life within its lease."""

    def look(self) -> None:
        """Report peers that do not fit, if the middleware does not tell of them by itself."""


class _Count:
    """Something that is counted, and reported at once, but then once in a while only."""

    def __init__(self, text: str, read: Callable[[], int]) -> None:
        self._text = text
        self._read = read
        self._reported = 0
        self._next = 0.0

    def report(self, *, finally_: bool = False) -> None:
        """Log how often it happened since the last report."""
        count = self._read() - self._reported
        now = time.monotonic()
        if count > 0 and (finally_ or now >= self._next):
            times = "once" if count == 1 else f"{count} times"
            log.warning(self._text, times)
            self._reported += count
            self._next = now + _QUIET


class QosWatch:
    """A thread that looks at ends with a deadline or a lease, and at those that must be asked."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: list[_Count] = []
        self._ends: list[End] = []
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ros2-qos", daemon=True)

    def add(self, topic: str, end: object, profile: Profile, *, writes: bool) -> None:
        """Watch an end of a topic until `close`."""
        if not isinstance(end, End):
            return
        with self._lock:
            self._ends.append(end)
            if profile.deadline is not None:
                within = f"within its deadline of {seconds(profile.deadline)} s, %s"
                what = "nothing was published" if writes else "no message came"
                text = f"{topic}: {what} {within}"
                self._counts.append(_Count(text, lambda: end.missed_deadlines))
            if writes or profile.lease is not None:
                which = "this publisher" if writes else "a publisher"
                text = (
                    f"{topic}: {which} showed no sign of life within its lease"
                    f" (liveliness), %s"
                )
                self._counts.append(_Count(text, lambda: end.lost_liveliness))
            if not self._thread.is_alive() and not self._closing.is_set():
                self._thread.start()

    def close(self) -> None:
        """Report what was not, and end the thread."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()
        for each in self._counts:
            each.report(finally_=True)

    def _run(self) -> None:
        while not self._closing.wait(_INTERVAL):
            with self._lock:
                ends, counts = [*self._ends], [*self._counts]
            try:
                for end in ends:
                    end.look()
                for count in counts:
                    count.report()
            except Exception:
                log.exception("the QoS of topics is watched no more")
                return
