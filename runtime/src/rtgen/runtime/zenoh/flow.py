"""Back pressure between a publisher and the subscriptions that keep all samples.

Zenoh's own congestion control acts on links, and would stop everything else that goes over them.
So a subscription acknowledges what it has handled, and a publisher sends at most a window ahead of
the slowest one. A subscription that is lost no longer counts: its liveliness token ends.

Samples that did not arrive, such as during changes of a link or subscription, would never be
acknowledged. So a waiting publisher repeatedly reports the last sample that it has sent, and a
subscription that is idle and received nothing from it between two reports acknowledges the second.
"""

from __future__ import annotations

import struct
import threading
import time
from typing import Any, TypeAlias

import zenoh

from rtgen.runtime.distribution.medium import SEQUENCES, PublishTimeoutError
from rtgen.runtime.failures import log
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.session import plain, reported

WINDOW = 64
"""Samples that are under way to the slowest subscription at most."""

_EVERY = WINDOW // 4
_REPORTS = 0.05
"""Seconds between the reports of a publisher that waits."""
_PUBLISHERS = 256
"""Maximum number of publishers that a subscription remembers."""
_PUBLISHER = struct.Struct("<16sI")
_REPORT = struct.Struct(f"<{_PUBLISHER.size}sI")
"""A publisher, and the number of a sample that was sent or handled."""

Source: TypeAlias = tuple[bytes, int]
"""A publisher: the identity of its session, without trailing zeros, and its number there."""


def source_of(identity: zenoh.EntityGlobalId) -> Source:
    """Return a publisher of this identity."""
    zid: Any = identity.zid
    return bytes(zid), identity.eid


def _sent(key: str) -> str:
    """Return the key of reports for the key of a subscription, which may be a pattern."""
    return f"{key}/sent"


class Acknowledging:
    """The receiving end: a token, and acknowledgements by publisher.

    Created before the subscription, so that publishers count it before they send to it.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._busy = False
        self._idle: set[Source] = set()
        """The publishers that have sent nothing since their last report."""
        self._publisher = session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.BLOCK, express=True
        )
        self._declared = Declared(session, self._publisher)
        self._declared.add(session.declare_subscriber(_sent(key), self._on_report))
        self._declared.add(session.liveliness().declare_token(key))

    def begin(self, source: Source) -> None:
        """Mark a sample as being handled."""
        self._busy = True
        self._idle.discard(source)

    def handled(self, source: Source, sequence: int) -> None:
        """Acknowledge a sample, with all before it; not each one causes a message."""
        self._busy = False
        if not sequence % _EVERY:
            self._acknowledge(_REPORT.pack(_PUBLISHER.pack(*source), sequence))

    def _on_report(self, sample: zenoh.Sample) -> None:
        octets = sample.payload.to_bytes()
        if len(octets) != _REPORT.size:
            return
        session, number = _PUBLISHER.unpack_from(octets)
        source = session.rstrip(b"\0"), number
        if source in self._idle and not self._busy:
            self._acknowledge(octets)
        if len(self._idle) >= _PUBLISHERS:
            self._idle.clear()
        self._idle.add(source)

    def _acknowledge(self, octets: bytes) -> None:
        with self._declared.using:
            if self._declared.closed:
                return
            try:
                self._publisher.put(octets)
            except zenoh.ZError as error:
                log.debug("zenoh: %s", plain(error))

    def close(self) -> None:
        """No longer count."""
        self._declared.close()


class Window:
    """The sending end: waits until the slowest subscription is less than a window behind.

    `keys` is the pattern of the keys of subscriptions.
    """

    def __init__(
        self, session: zenoh.Session, keys: str, source: Source, patience: float
    ) -> None:
        self._session = session
        self._keys = keys
        self._publisher = _PUBLISHER.pack(*source)
        self._patience = patience
        self._changed = threading.Condition()
        self._handled: dict[str, int] = {}
        self._sent = 0
        self._reported = 0.0
        """When, by the monotonic clock [s]."""
        self._closed = False
        self._declared = Declared(
            session,
            session.declare_subscriber(keys, self._on_acknowledgement),
            session.liveliness().declare_subscriber(keys, self._on_token, history=True),
        )

    def wait(self, name: str) -> None:
        """Wait for room for a sample, which is sent next. Raises PublishTimeoutError."""
        deadline = time.monotonic() + self._patience
        while not self._take_place(deadline - time.monotonic()):
            now = time.monotonic()
            if now >= self._reported + _REPORTS:
                self._reported = now
                self._report(name)
            if now >= deadline:
                raise PublishTimeoutError(
                    f"{name}: a subscription is {WINDOW} samples behind for "
                    f"{self._patience} s"
                )

    def _take_place(self, seconds: float) -> bool:
        """Return whether there is room for a sample in time, at most until the next report."""
        with self._changed:
            if not self._changed.wait_for(self._has_room, min(seconds, _REPORTS)):
                return False
            self._sent += 1
            return True

    def _report(self, name: str) -> None:
        """Report the last sample; a full link drops the report, since samples are on their way."""
        last = (self._sent - 1) % SEQUENCES
        with reported(name):
            self._session.put(
                _sent(self._keys),
                _REPORT.pack(self._publisher, last),
                congestion_control=zenoh.CongestionControl.DROP,
            )

    def close(self) -> None:
        """Wait no more."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._declared.close()

    def _has_room(self) -> bool:
        slowest = min(self._handled.values(), default=self._sent)
        return self._closed or self._sent - slowest < WINDOW

    def _on_token(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        with self._changed:
            if sample.kind == zenoh.SampleKind.PUT:
                self._handled.setdefault(key, self._sent)
            else:
                self._handled.pop(key, None)
            self._changed.notify_all()

    def _on_acknowledgement(self, sample: zenoh.Sample) -> None:
        octets = sample.payload.to_bytes()
        if len(octets) != _REPORT.size:
            return
        publisher, sequence = _REPORT.unpack(octets)
        key = str(sample.key_expr)
        with self._changed:
            if publisher == self._publisher and key in self._handled:
                # The number of the first sample is 0.
                behind = (self._sent - 1 - sequence) % SEQUENCES
                self._handled[key] = max(self._handled[key], self._sent - behind)
                self._changed.notify_all()
