"""Ends of topics over Zenoh: attachments with their numbers, and the peers of a topic."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from itertools import count
from typing import Any, Final, NamedTuple

import xxhash
import zenoh

from rtgen.facts import ros_zenoh
from rtgen.facts.ros_names import GID_SIZE
from rtgen.facts.ros_qos import SECOND, Liveliness, Profile
from rtgen.facts.ros_zenoh import Attachment
from rtgen.runtime.distribution.deadlines import Deadline
from rtgen.runtime.distribution.medium import OnSample
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.qos import Own, Peers
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.session import reported
from rtgen.runtime.zenoh.topics import ZenohSubscription

_MAX_PUBLISHERS: Final = 1024
"""Maximum number of publishers of a topic whose messages are counted."""


class Shown(NamedTuple):
    """The token of an entity, with its text, and its identifier in attachments."""

    token: Any
    text: str
    gid: bytes


class Attachments:
    """The attachments of one entity, numbered."""

    def __init__(self, gid: bytes) -> None:
        self._gid = gid
        self._numbers = count(1)

    def next(self) -> bytes:
        """Return the attachment of what is sent now."""
        value = Attachment(next(self._numbers), time.time_ns(), self._gid)
        return ros_zenoh.attachment(value)


def gid_of(token: str) -> bytes:
    """Return the identifier of an entity in attachments: XXH3 of its token, of 128 bits.

    The lower half comes first, little-endian, as in rmw_zenoh (liveliness_utils.cpp).
    """
    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(GID_SIZE, "little")


def deadline_of(profile: Profile) -> float | None:
    """Return the deadline in seconds."""
    return None if profile.deadline is None else profile.deadline / SECOND


class RosPublisher:
    """See `medium.Publisher` and `qos.End`: each sample has an attachment."""

    lost_liveliness = 0

    def __init__(
        self,
        session: zenoh.Session,
        publisher: Any,
        shown: Shown,
        profile: Profile,
        *,
        is_durable: bool,
    ) -> None:
        self._publisher = publisher
        self._is_durable = is_durable
        self._attachments = Attachments(shown.gid)
        self._deadline = Deadline(deadline_of(profile))
        self._lock = threading.Lock()
        self._declared = Declared(session, publisher, shown.token)

    def add(self, declaration: Any) -> None:
        """Withdraw this declaration, too, when this is closed."""
        self._declared.add(declaration)

    def publish(self, octets: bytes) -> None:
        """See `medium.Publisher`."""
        with self._lock, reported("Zenoh"):
            self._publisher.put(octets, attachment=self._attachments.next())
        self._deadline.met()

    @property
    def matched(self) -> bool:
        """See `medium.Publisher`; Zenoh does not tell it of one that is durable."""
        with reported("Zenoh"):
            return self._is_durable or self._declared.matches(self._publisher)

    @property
    def missed_deadlines(self) -> int:
        """See `qos.End`."""
        return self._deadline.missed

    def look(self) -> None:
        """See `qos.End`; tokens tell of peers."""

    def close(self) -> None:
        """See `medium.Publisher`."""
        self._deadline.end()
        self._declared.close()


class RosSubscription(ZenohSubscription):
    """See `medium.Subscription` and `qos.End`: the numbers of attachments show what is lost."""

    lost_liveliness = 0

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        on_sample: OnSample,
        history: int | None,
        profile: Profile,
    ) -> None:
        self.lost = 0
        self._last: OrderedDict[bytes, int] = OrderedDict()
        super().__init__(session, key, on_sample, history, deadline_of(profile))

    def look(self) -> None:
        """See `qos.End`; tokens tell of peers."""

    def _received(self, received: zenoh.Sample) -> None:
        if received.attachment is not None:
            self._count(received.attachment.to_bytes())
        super()._received(received)

    def _count(self, octets: bytes) -> None:
        """Count the messages between this and the last one of its publisher."""
        try:
            came = ros_zenoh.parse_attachment(octets)
        except ValueError:
            return
        last = self._last.get(came.gid)
        if last is not None and came.sequence <= last:
            return
        if last is not None:
            self.lost += came.sequence - last - 1
        self._last[came.gid] = came.sequence
        if len(self._last) > _MAX_PUBLISHERS:
            self._last.popitem(last=False)


class Discovery:
    """Compares ends of this process with those whose tokens are on the same topics."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._peers = Peers(delivers=True)

    def watch(
        self, domain: int, name: str, type_name: str, own: Own
    ) -> zenoh.Subscriber[None]:
        """Return the declaration by which the other ends of a topic are found. Raises ZError."""
        kind = ros_zenoh.SUBSCRIPTION if own.writes else ros_zenoh.PUBLISHER
        key = ros_zenoh.tokens_of(domain, kind, name, type_name)
        found = self._peer_observer(name, own)
        return self._session.liveliness().declare_subscriber(key, found, history=True)

    def _peer_observer(self, name: str, own: Own) -> Callable[[zenoh.Sample], None]:
        def found(sample: zenoh.Sample) -> None:
            if sample.kind != zenoh.SampleKind.PUT:
                return
            try:
                token = str(sample.key_expr)
                node, profile = ros_zenoh.parse_entity(token)
            except ValueError:
                return
            self._peers.compare(name, own, token, profile, lambda: node)

        return found


def report_ignored(topic: str, profile: Profile, *, writes: bool) -> None:
    """Log the policies that Zenoh has nothing for; others see them in the token."""
    ignored = [
        *(["lifespan"] if writes and profile.lifespan is not None else []),
        *(["lease"] if profile.lease is not None else []),
        *(["liveliness"] if profile.liveliness is not Liveliness.AUTOMATIC else []),
    ]
    if ignored:
        which = ", ".join(ignored)
        log.warning("%s: %s has no effect over Zenoh", topic, which)
