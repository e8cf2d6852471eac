"""Zenoh as a `Medium`: topics by publishers and subscribers, services by queryables, presence by
liveliness tokens."""

from __future__ import annotations

import threading
import uuid
from collections import Counter
from collections.abc import Sequence
from functools import partial
from weakref import WeakSet

import zenoh

from rtgen.runtime.distribution.medium import (
    Client,
    OnChange,
    OnRequest,
    OnSample,
    Publisher,
    Qos,
    ServiceTypes,
    Subscription,
    Token,
    Topic,
    check_lease,
    check_name,
)
from rtgen.runtime.freed_memory import keep_freed_memory
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.keys import Keys
from rtgen.runtime.zenoh.services import OneServerClient, ZenohService
from rtgen.runtime.zenoh.session import Endpoints, lease_of, open_session, reported
from rtgen.runtime.zenoh.topics import (
    ZenohPublisher,
    ZenohSubscription,
    is_small,
    kept_samples,
    publisher_of,
)


class ZenohEngine:
    """One process's session, with its declarations."""

    def __init__(self, session: zenoh.Session) -> None:
        keep_freed_memory()
        self._session = session
        self._kept: set[Declared] = set()

    def close(self) -> None:
        """See `Messaging`. That withdraws all declarations, including those in use."""
        self._kept.clear()
        if not self._session.is_closed():
            with reported("zenoh"):
                self._session.close()


class ZenohMedium(ZenohEngine):
    """One process's part in the system of this name, over a session of its own.

    Raises MediumError.
    """

    def __init__(self, system: str, endpoints: Endpoints | None = None) -> None:
        self._keys = Keys.of(system)
        self._endpoints = endpoints or Endpoints()
        super().__init__(open_session(self._endpoints))
        self._served: Counter[str] = Counter()
        self._publishers: WeakSet[ZenohPublisher] = WeakSet()

    def publisher(self, topic: Topic, qos: Qos) -> Publisher:
        """See `Medium`. The lease is that of the session, which cannot be shortened later."""
        if qos.lease is not None:
            check_lease(topic, qos, lease_of(self._endpoints))
        with reported(topic.name):
            end = publisher_of(self._session, self._keys, topic, qos)
        self._publishers.add(end)
        return end

    def subscribe(self, topic: Topic, qos: Qos, on_sample: OnSample) -> Subscription:
        """See `Medium`."""
        with reported(topic.name):
            return ZenohSubscription(
                self._session,
                self._keys.topic(topic),
                on_sample,
                kept_samples(qos) if qos.durable else None,
                qos.deadline,
                self._keys.flow(topic, uuid.uuid4().hex) if qos.depth is None else None,
                waits=qos.depth is None or not is_small(topic.type),
            )

    def serve(
        self, service: str, types: Sequence[ServiceTypes], on_request: OnRequest
    ) -> Token:
        """See `Medium`."""
        key = self._keys.service(service)
        with reported(service):
            server = ZenohService(
                self._session,
                key,
                on_request,
                end=partial(self._served.subtract, (key,)),
            )
            server.add(self._session.liveliness().declare_token(key))
        self._served[key] += 1
        return server.kept_by(self._kept)

    def client(self, service: str, types: ServiceTypes) -> Client:
        """See `Medium`."""
        key = self._keys.service(service)
        with reported(service):
            return OneServerClient(self._session, key, service, self._served)

    def announce(self, name: str) -> Token:
        """See `Medium`."""
        key = self._keys.presence(check_name(name), uuid.uuid4().hex)
        with reported(name):
            token = self._session.liveliness().declare_token(key)
        return Declared(self._session, token).kept_by(self._kept)

    def watch(self, prefix: str, on_change: OnChange) -> Token:
        """See `Medium`."""
        watching = _Presences(self._keys, prefix, on_change)
        with reported(prefix):
            subscriber = self._session.liveliness().declare_subscriber(
                self._keys.presences(prefix), watching.on_token, history=True
            )
        token = Declared(self._session, subscriber, end=watching.end)
        return token.kept_by(self._kept)

    def close(self) -> None:
        """See `Medium`."""
        for publisher in tuple(self._publishers):
            publisher.close()
        super().close()


class _Presences:
    """Counts the tokens of each name, and notifies of the first and the last."""

    def __init__(self, keys: Keys, prefix: str, on_change: OnChange) -> None:
        self._keys = keys
        self._prefix = prefix
        self._on_change: OnChange | None = on_change
        self._tokens: dict[str, set[str]] = {}
        self._lock = threading.Lock()

    def on_token(self, sample: zenoh.Sample) -> None:
        """A token came or went; a lost link can report one twice."""
        key = str(sample.key_expr)
        name = self._keys.present(key)
        if not name or not name.startswith(self._prefix):
            return
        with self._lock:
            tokens = self._tokens.setdefault(name, set())
            before = bool(tokens)
            if sample.kind == zenoh.SampleKind.PUT:
                tokens.add(key)
            else:
                tokens.discard(key)
            after = bool(tokens)
            if not after:
                del self._tokens[name]
            notify = self._on_change
        if notify is not None and before is not after:
            notify(name, after)

    def end(self) -> None:
        """Notify no more."""
        self._on_change = None
