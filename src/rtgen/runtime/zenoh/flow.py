"""Back pressure between a publisher and the subscriptions that keep all samples.

Zenoh's own congestion control acts on links, and would stop everything else that goes over them.
So a subscription acknowledges what it has handled, and a publisher sends at most a window ahead of
the slowest one. A subscription that is lost no longer counts: its liveliness token ends.
"""

from __future__ import annotations

import struct
import threading
from typing import Any, TypeAlias

import zenoh

from rtgen.runtime.distribution.medium import SEQUENCES, PublishTimeoutError
from rtgen.runtime.failures import log
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.session import plain

WINDOW = 64
"""Samples that are under way to the slowest subscription at most."""

_EVERY = WINDOW // 4
_PUBLISHER = struct.Struct("<16sI")
_ACKNOWLEDGEMENT = struct.Struct(f"<{_PUBLISHER.size}sI")
"""A publisher, and the number of a sample."""

Source: TypeAlias = tuple[bytes, int]
"""A publisher: the identity of its session, without trailing zeros, and its number there."""


def source_of(identity: zenoh.EntityGlobalId) -> Source:
    """A publisher of this identity."""
    zid: Any = identity.zid
    return bytes(zid), identity.eid


class Acknowledging:
    """The receiving end: a token, and acknowledgements by publisher."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._publisher = session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.BLOCK, express=True
        )
        token = session.liveliness().declare_token(key)
        self._declared = Declared(session, self._publisher, token)

    def handled(self, source: Source, sequence: int) -> None:
        """Acknowledge a sample, with all before it; not each one causes a message."""
        if sequence % _EVERY:
            return
        try:
            publisher = _PUBLISHER.pack(*source)
            self._publisher.put(_ACKNOWLEDGEMENT.pack(publisher, sequence))
        except zenoh.ZError as error:
            log.debug("zenoh: %s", plain(error))

    def close(self) -> None:
        """No longer count."""
        self._declared.close()


class Window:
    """The sending end: waits until the slowest subscription is less than a window behind."""

    def __init__(
        self, session: zenoh.Session, keys: str, source: Source, patience: float
    ) -> None:
        self._publisher = _PUBLISHER.pack(*source)
        self._patience = patience
        self._changed = threading.Condition()
        self._handled: dict[str, int] = {}
        self._sent = 0
        self._closed = False
        self._declared = Declared(
            session,
            session.declare_subscriber(keys, self._on_acknowledgement),
            session.liveliness().declare_subscriber(keys, self._on_token, history=True),
        )

    def wait(self, name: str) -> None:
        """Wait for room for a sample, which is sent then. Raises PublishTimeoutError."""
        with self._changed:
            if not self._changed.wait_for(self._has_room, self._patience):
                raise PublishTimeoutError(
                    f"{name}: a subscription is {WINDOW} samples behind for "
                    f"{self._patience} s"
                )
            self._sent += 1

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
        if len(octets) != _ACKNOWLEDGEMENT.size:
            return
        publisher, sequence = _ACKNOWLEDGEMENT.unpack(octets)
        key = str(sample.key_expr)
        with self._changed:
            if publisher == self._publisher and key in self._handled:
                # The number of the first sample is 0.
                behind = (self._sent - 1 - sequence) % SEQUENCES
                self._handled[key] = max(self._handled[key], self._sent - behind)
                self._changed.notify_all()
