"""Services as queryables, calls as queries: one server each, never repeated."""

from __future__ import annotations

import threading
from collections import Counter
from functools import partial

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
    """A queryable with a token. `complete`: a query goes to one of several servers only."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        on_request: OnRequest,
        served: Counter[str],
    ) -> None:
        super().__init__(session, end=partial(served.subtract, (key,)))
        self._key = key
        self._on_request = on_request
        # The first query may come before `declare_queryable` returns.
        self.add(session.declare_queryable(key, self._on_query, complete=True))
        self.add(session.liveliness().declare_token(key))
        served[key] += 1

    def _on_query(self, query: zenoh.Query) -> None:
        if self.closed:
            return
        payload = query.payload
        octets = b"" if payload is None else payload.to_bytes()
        self._on_request(octets, partial(_reply, self._key, query))


def _reply(key: str, query: zenoh.Query, octets: bytes) -> None:
    try:
        with query:
            query.reply(key, octets)
    except zenoh.ZError as error:
        log.debug("%s: the client is gone: %s", key, plain(error))


class ZenohClient:
    """See `medium.Client`."""

    def __init__(
        self, session: zenoh.Session, key: str, service: str, served: Counter[str]
    ) -> None:
        self._session = session
        self._key = key
        self._service = service
        self._served = served
        self._lock = threading.Lock()
        self._calls: set[zenoh.CancellationToken] = set()
        self._querier = session.declare_querier(key)
        self._closing = Declared(session, self._querier, end=self._cancel)

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`."""
        here = self._served[self._key] > 0
        cancellation = zenoh.CancellationToken()
        with self._lock:
            if self._closing.closed:
                raise MediumError(f"the client of {self._service} is closed")
            self._calls.add(cancellation)
        try:
            with reported(self._service):
                if not here and not self._is_served(timeout):
                    raise NotServedError(f"nobody serves {self._service}")
                # A session sends a query to its own queryable and to another one.
                replies = self._session.get(
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
            for reply in replies:
                return self._result(reply, timeout)
        finally:
            with self._lock:
                self._calls.discard(cancellation)
        raise PeerLostError(f"no reply of {self._service}: its server was lost")

    def send(self, octets: bytes, timeout: float) -> None:
        """See `medium.Client`: servers reply to a oneway request at once."""
        self.call(octets, timeout)

    def _is_served(self, timeout: float) -> bool:
        """Whether there is a server; the routers are asked if this session knows of none."""
        if self._closing.matches(self._querier):
            return True
        tokens = self._session.liveliness().get(self._key, timeout=timeout)
        return any(token.ok is not None for token in tokens)

    def _result(self, reply: zenoh.Reply, timeout: float) -> bytes:
        if reply.ok is not None:
            octets: bytes = reply.ok.payload.to_bytes()
            return octets
        error = b"" if reply.err is None else reply.err.payload.to_bytes()
        if error == _TIMEOUT:
            raise ReplyTimeoutError(f"no reply of {self._service} in {timeout} s")
        raise PeerLostError(f"{self._service} answered with an error of Zenoh")

    def close(self) -> None:
        """See `medium.Client`."""
        self._closing.close()

    def _cancel(self) -> None:
        with self._lock:
            calls = list(self._calls)
        for call in calls:
            call.cancel()
