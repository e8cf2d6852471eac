"""Topics: publishers and subscribers of Zenoh, with history for late joiners.

The payload of a sample is the serialized value. Zenoh's own source information, which an advanced
publisher adds, has the identity of the publisher and the number of the sample; samples of programs
without rtgen need none.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import inf, prod
from typing import Any

import zenoh
from zenoh import ext

from rtgen.facts.primitives import SCALARS
from rtgen.runtime.distribution.deadlines import Deadline
from rtgen.runtime.distribution.medium import (
    MediumError,
    OnSample,
    Qos,
    Sample,
    Topic,
)
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    BitsetDescriptor,
    EnumDescriptor,
    FlagsDescriptor,
    PrimitiveDescriptor,
    StructDescriptor,
    plain,
)
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.flow import Acknowledging, Window, source_of
from rtgen.runtime.zenoh.keys import Keys
from rtgen.runtime.zenoh.session import reported

_FEW_NUMBERS = 128
_MAX_KEPT = 4096
"""Samples kept for late joiners by a topic that keeps all."""


def publisher_of(
    session: zenoh.Session, keys: Keys, topic: Topic, qos: Qos
) -> ZenohPublisher:
    """Return a publisher of a topic. Raises zenoh.ZError."""
    kind = ZenohPublisher if qos.depth is not None else WaitingPublisher
    return kind(session, keys, topic, qos)


class ZenohPublisher:
    """See `medium.Publisher`. Zenoh numbers the samples.

    `publish` is Zenoh's own `put`, which only fails for closed publishers and sessions; a call
    around it that turned its errors into MediumError would take a twentieth of its time.
    """

    def __init__(
        self, session: zenoh.Session, keys: Keys, topic: Topic, qos: Qos
    ) -> None:
        key = keys.topic(topic)
        self._name = topic.name
        # An advanced publisher does not report whether it is matched; one with the same key does.
        self._twin = session.declare_publisher(key)
        publisher = ext.declare_advanced_publisher(
            session,
            key,
            encoding=zenoh.Encoding.APPLICATION_CDR,
            congestion_control=_congestion_control(qos),
            reliability=reliability(qos),
            sample_miss_detection=ext.MissDetectionConfig(
                heartbeat=None, sporadic_heartbeat=None
            ),
            cache=ext.CacheConfig(kept_samples(qos)) if qos.durable else None,
            publisher_detection=qos.durable,
        )
        self._source = source_of(publisher.id)
        self.publish: Callable[[bytes], None] = publisher.put
        self._declared = Declared(session, self._twin, publisher)

    @property
    def matched(self) -> bool:
        """See `medium.Publisher`."""
        with reported(self._name):
            return self._declared.matches(self._twin)

    def close(self) -> None:
        """See `medium.Publisher`."""
        self.publish = self._refuse
        self._declared.close()

    def _refuse(self, octets: bytes) -> None:
        raise MediumError(f"the publisher of {self._name} is closed")


class WaitingPublisher(ZenohPublisher):
    """A publisher that keeps all samples: it waits for acknowledging subscriptions."""

    def __init__(
        self, session: zenoh.Session, keys: Keys, topic: Topic, qos: Qos
    ) -> None:
        super().__init__(session, keys, topic, qos)
        flow = keys.flow(topic, "*")
        window = self._window = Window(session, flow, self._source, qos.patience)
        put = self.publish

        def publish(octets: bytes) -> None:
            window.wait(topic.name)
            with reported(topic.name):
                put(octets)

        self.publish = publish

    def close(self) -> None:
        """See `medium.Publisher`."""
        self._window.close()
        super().close()


class ZenohSubscription:
    """See `medium.Subscription`. Sequence numbers show what is lost."""

    lost = 0

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        on_sample: OnSample,
        history: int | None = None,
        deadline: float | None = None,
        flow: str | None = None,
        *,
        waits: bool = True,
    ) -> None:
        """Declare it.

        `history`: number of samples of the past, None for a volatile one; `deadline` [s] as in
        `Qos`; `flow`: key of the acknowledgements of one that keeps all samples; `waits`: whether
        `on_sample` may wait or samples are large, so that it has a thread of its own. Else it is
        called in the threads that read from links, which spares a change of threads.
        """
        self._on_sample = on_sample
        self._deadline = Deadline(deadline)
        self._acknowledging: Acknowledging | None = None
        if flow is not None:
            self._acknowledging = Acknowledging(session, flow)
        subscriber: Any
        self._closed = False
        if history is not None:
            subscriber = ext.declare_advanced_subscriber(
                session,
                key,
                self._received,
                history=ext.HistoryConfig(
                    detect_late_publishers=True,
                    max_samples=history,
                ),
            )
        elif waits:
            subscriber = session.declare_subscriber(key, self._received)
        else:
            self._one_by_one = threading.RLock()
            handler: Any = zenoh.handlers.Callback(
                self._received_directly, indirect=False
            )
            subscriber = session.declare_subscriber(key, handler)
        self._declared = Declared(session, subscriber)

    def add(self, declaration: Any) -> None:
        """Withdraw this declaration, too, when this is closed."""
        self._declared.add(declaration)

    @property
    def missed_deadlines(self) -> int:
        """See `medium.Subscription`."""
        return self._deadline.missed

    def _received_directly(self, received: zenoh.Sample) -> None:
        # Each link has a thread, and a sender in this process its own.
        with self._one_by_one:
            self._received(received)

    def _received(self, received: zenoh.Sample) -> None:
        if self._closed:
            return
        octets = received.payload.to_bytes()
        # Deletions have no payload, and values some: each question to Zenoh takes its time.
        if not octets and received.kind != zenoh.SampleKind.PUT:
            return
        self._deadline.met()
        info = received.source_info
        if info is None:
            self._on_sample(Sample(octets, None))
            return
        source, sequence = source_of(info.source_id), info.source_sn
        if self._acknowledging is None:
            self._on_sample(Sample(octets, source, sequence))
            return
        self._acknowledging.begin(source)
        self._on_sample(Sample(octets, source, sequence))
        self._acknowledging.handled(source, sequence)

    def close(self) -> None:
        """See `medium.Subscription`."""
        self._closed = True
        self._deadline.end()
        self._declared.close()
        if self._acknowledging is not None:
            self._acknowledging.close()


def is_small(type_: Any) -> bool:
    """Return whether samples of a type have few octets: numbers, and arrays of them."""
    return _numbers(type_._descriptor_) <= _FEW_NUMBERS


def _numbers(descriptor: Any) -> float:
    """Return the number of numbers in a value, infinite without a limit."""
    match plain(descriptor):
        case PrimitiveDescriptor(name=name):
            return 1 if name in SCALARS else inf
        case EnumDescriptor() | FlagsDescriptor() | BitsetDescriptor():
            return 1
        case StructDescriptor(members=members):
            return sum(_numbers(member.type) for member in members)
        case ArrayDescriptor(element=element, dimensions=dimensions):
            return prod(dimensions) * _numbers(element)
        case _:
            return inf


def _congestion_control(qos: Qos) -> zenoh.CongestionControl:
    blocks = qos.depth is None
    return zenoh.CongestionControl.BLOCK if blocks else zenoh.CongestionControl.DROP


def kept_samples(qos: Qos) -> int:
    """Return the number of samples that are kept for late joiners."""
    return _MAX_KEPT if qos.depth is None else qos.depth


def reliability(qos: Qos) -> zenoh.Reliability:
    """Return Zenoh's word for it."""
    if qos.reliable:
        return zenoh.Reliability.RELIABLE
    return zenoh.Reliability.BEST_EFFORT
