"""Topics: publishers and subscribers of Zenoh, with history for late joiners.

The payload of a sample is the serialized value. Its attachment of 24 octets has the identity of
the publisher (16) and the number of the sample (8, little-endian); samples of programs without
rtgen need none. Durable topics use Zenoh's own advanced publishers and subscribers.
"""

from __future__ import annotations

import struct
import uuid
from typing import Any, TypeAlias

import zenoh
from zenoh import ext

from rtgen.runtime.distribution.deadlines import Deadline
from rtgen.runtime.distribution.medium import (
    MediumError,
    OnSample,
    Qos,
    Sample,
    Topic,
)
from rtgen.runtime.zenoh.declared import Declared, matches
from rtgen.runtime.zenoh.flow import Acknowledging, Window
from rtgen.runtime.zenoh.keys import Keys
from rtgen.runtime.zenoh.session import plain

_ATTACHMENT = struct.Struct("<16sQ")
_MOST_KEPT = 4096
"""Samples kept for late joiners by a topic that keeps all."""

_Publisher: TypeAlias = zenoh.Publisher | ext.AdvancedPublisher


class ZenohPublisher:
    """See `medium.Publisher`. One that keeps all samples waits for those who acknowledge."""

    def __init__(
        self, session: zenoh.Session, keys: Keys, topic: Topic, qos: Qos
    ) -> None:
        key = keys.topic(topic)
        self._name = topic.name
        self._identity = uuid.uuid4().bytes
        plainly = session.declare_publisher(
            key,
            encoding=zenoh.Encoding.APPLICATION_CDR,
            congestion_control=_congestion_control(qos),
            reliability=_reliability(qos),
        )
        declared: list[Any] = [plainly]
        self._plainly = plainly
        publisher: _Publisher = plainly
        if qos.durable:
            publisher = ext.declare_advanced_publisher(
                session,
                key,
                encoding=zenoh.Encoding.APPLICATION_CDR,
                congestion_control=_congestion_control(qos),
                reliability=_reliability(qos),
                cache=ext.CacheConfig(_MOST_KEPT if qos.depth is None else qos.depth),
                sample_miss_detection=ext.MissDetectionConfig(
                    heartbeat=None, sporadic_heartbeat=None
                ),
                publisher_detection=True,
            )
            declared.append(publisher)
        self._put = publisher.put
        self._window: Window | None = None
        if qos.depth is None:
            flow = keys.flow(topic, "*")
            self._window = Window(session, flow, self._identity, qos.patience)
        self._declared = Declared(session, *declared)

    def publish(self, octets: bytes, sequence: int) -> None:
        """See `medium.Publisher`."""
        if self._window is not None:
            self._window.wait(sequence, self._name)
        try:
            attachment = _ATTACHMENT.pack(self._identity, sequence)
            self._put(octets, attachment=attachment)
        except zenoh.ZError as error:
            raise MediumError(f"{self._name}: {plain(error)}") from error

    @property
    def matched(self) -> bool:
        """See `medium.Publisher`."""
        try:
            return matches(self._plainly)
        except zenoh.ZError as error:
            raise MediumError(f"{self._name}: {plain(error)}") from error

    def close(self) -> None:
        """See `medium.Publisher`."""
        if self._window is not None:
            self._window.close()
        self._declared.close()


class ZenohSubscription:
    """See `medium.Subscription`. Sequence numbers show what is lost."""

    lost = 0

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        topic: Topic,
        qos: Qos,
        on_sample: OnSample,
    ) -> None:
        self._on_sample = on_sample
        self._deadline = Deadline(qos.deadline)
        self._acknowledging: Acknowledging | None = None
        if qos.depth is None:
            self._acknowledging = Acknowledging(
                session, keys.flow(topic, uuid.uuid4().hex)
            )
        key = keys.topic(topic)
        subscriber: Any
        self._closed = False
        if qos.durable:
            subscriber = ext.declare_advanced_subscriber(
                session,
                key,
                self._received,
                history=ext.HistoryConfig(
                    detect_late_publishers=True,
                    max_samples=_MOST_KEPT if qos.depth is None else qos.depth,
                ),
            )
        else:
            subscriber = session.declare_subscriber(key, self._received)
        self._declared = Declared(session, subscriber)

    @property
    def missed_deadlines(self) -> int:
        """See `medium.Subscription`."""
        return self._deadline.missed

    def _received(self, received: zenoh.Sample) -> None:
        if self._closed or received.kind != zenoh.SampleKind.PUT:
            return
        self._deadline.met()
        source, sequence = _origin(received)
        self._on_sample(Sample(received.payload.to_bytes(), source, sequence))
        if self._acknowledging is not None and sequence is not None:
            self._acknowledging.handled(source, sequence)

    def close(self) -> None:
        """See `medium.Subscription`."""
        self._closed = True
        self._deadline.end()
        self._declared.close()
        if self._acknowledging is not None:
            self._acknowledging.close()


def _origin(received: zenoh.Sample) -> tuple[bytes, int | None]:
    """Publisher and number of a sample; a program without rtgen gives none."""
    attachment = received.attachment
    octets = b"" if attachment is None else attachment.to_bytes()
    if len(octets) != _ATTACHMENT.size:
        return b"", None
    identity, sequence = _ATTACHMENT.unpack(octets)
    return identity, sequence


def _congestion_control(qos: Qos) -> zenoh.CongestionControl:
    blocks = qos.depth is None
    return zenoh.CongestionControl.BLOCK if blocks else zenoh.CongestionControl.DROP


def _reliability(qos: Qos) -> zenoh.Reliability:
    if qos.reliable:
        return zenoh.Reliability.RELIABLE
    return zenoh.Reliability.BEST_EFFORT
