"""Services as queryables, calls as queries: one server each, never repeated."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import zenoh

from rtgen.runtime.distribution.medium import (
    MediumError,
    NotServedError,
    OnRequest,
    PeerLostError,
    ReplyTimeoutError,
)
from rtgen.runtime.failures import log
from rtgen.runtime.zenoh.declared import Declared
from rtgen.runtime.zenoh.session import plain, reported

_TIMEOUT = b"Timeout"
"""The error by which Zenoh ends a query in time."""


class ZenohService(Declared):
    """A queryable. `complete`: a query goes to one of several servers only."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        on_request: OnRequest,
        end: Callable[[], None] | None = None,
    ) -> None:
        super().__init__(session, end=end)
        self._key = key
        self._on_request = on_request
        # The first query may come before `declare_queryable` returns.
        self.add(session.declare_queryable(key, self._on_query, complete=True))

    def _on_query(self, query: zenoh.Query) -> None:
        if self.closed:
            return
        self._on_request(_octets(query.payload), partial(self._reply, query))

    def _reply(self, query: zenoh.Query, octets: bytes, **options: Any) -> None:
        try:
            with query:
                query.reply(self._key, octets, **options)
        except zenoh.ZError as error:
            log.debug("%s: the client is gone: %s", self._key, plain(error))


def _octets(payload: zenoh.ZBytes | None) -> bytes:
    return b"" if payload is None else payload.to_bytes()


class ZenohClient(ABC):
    """See `medium.Client`."""

    def __init__(
        self, session: zenoh.Session, service: str, querier: zenoh.Querier
    ) -> None:
        self._session = session
        self._service = service
        self._querier = querier
        self._lock = threading.Lock()
        self._calls: set[zenoh.CancellationToken] = set()
        self._closing = Declared(session, querier, end=self.cancel)

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`."""
        cancellation = zenoh.CancellationToken()
        with self._lock:
            if self._closing.closed:
                raise MediumError(f"the client of {self._service} is closed")
            self._calls.add(cancellation)
        error = None
        try:
            with reported(self._service):
                for reply in self._ask(octets, timeout, cancellation):
                    if reply.ok is not None:
                        return _octets(reply.ok.payload)
                    error = _octets(reply.err.payload if reply.err else None)
        finally:
            with self._lock:
                self._calls.discard(cancellation)
        if error == _TIMEOUT:
            raise ReplyTimeoutError(f"no reply of {self._service} in {timeout} s")
        if error is not None:
            raise PeerLostError(f"{self._service} answered with an error of Zenoh")
        raise PeerLostError(f"no reply of {self._service}: its server was lost")

    @abstractmethod
    def _ask(
        self, octets: bytes, timeout: float, cancellation: zenoh.CancellationToken
    ) -> Iterable[zenoh.Reply]:
        """Send a query, and return its replies. Raises NotServedError, zenoh.ZError."""

    def send(self, octets: bytes, timeout: float) -> None:
        """See `medium.Client`: servers reply to a oneway request at once."""
        self.call(octets, timeout)

    def cancel(self) -> None:
        """See `medium.Client`."""
        with self._lock:
            calls = list(self._calls)
        for call in calls:
            call.cancel()

    def close(self) -> None:
        """See `medium.Client`."""
        self._closing.close()


class OneServerClient(ZenohClient):
    """A client of rtgen's services: one server gets a query."""

    def __init__(
        self, session: zenoh.Session, key: str, service: str, served: Counter[str]
    ) -> None:
        super().__init__(session, service, session.declare_querier(key))
        self._key = key
        self._served = served

    def _ask(
        self, octets: bytes, timeout: float, cancellation: zenoh.CancellationToken
    ) -> Iterable[zenoh.Reply]:
        here = self._served[self._key] > 0
        if not here and not self._is_served(timeout):
            raise NotServedError(f"nobody serves {self._service}")
        # A session sends a query to its own queryable and to another one.
        return self._session.get(
            self._key,
            payload=octets,
            timeout=timeout,
            cancellation_token=cancellation,
            consolidation=zenoh.ConsolidationMode.NONE,
            congestion_control=zenoh.CongestionControl.BLOCK,
            allowed_destination=(
                zenoh.Locality.SESSION_LOCAL if here else zenoh.Locality.REMOTE
            ),
        )

    def _is_served(self, timeout: float) -> bool:
        """Whether there is a server; the routers are asked if this session knows of none."""
        if self._closing.matches(self._querier):
            return True
        tokens = self._session.liveliness().get(self._key, timeout=timeout)
        return any(token.ok is not None for token in tokens)
