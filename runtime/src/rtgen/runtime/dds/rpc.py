"""Services as pairs of topics: both ends, and those of the basic mapping of DDS-RPC 1.0 (7.5.1).

A service has the topics `<service>Request` and `<service>Reply`; the types of samples and their
headers are `distribution.rpc_types` and `rpc_header`. A server's instance name is the GUID of its
reader: requests that name another one are not for it, so that one of several servers answers.

Replies are transient-local, so that a reply is not lost to a client whose reader the server has not
discovered yet.
"""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Collection, Hashable, Iterator, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple

from cyclonedds.core import DDSStatus
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher, Entry
from rtgen.runtime.dds.entities import Entities
from rtgen.runtime.distribution.medium import (
    MediumError,
    NotServedError,
    OnRequest,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
    ServiceTypes,
)
from rtgen.runtime.distribution.rpc_header import (
    directed,
    identity_of,
    server_of,
)
from rtgen.runtime.failures import log

_DISCOVERY = 0.25
"""Seconds that a call waits for a server to be discovered."""
_QOS = Qos(depth=None)
_REPLIES = Qos(depth=None, durable=True)
_LATE = 16
"""Number of replies for a client whose reader is discovered after they were written."""
_WRITE_TIMEOUT = 2.0
"""Seconds that a reply waits for slow clients."""

_OURS = b"rtgen"
"""User data of readers whose servers are selected by the GUID of their reader."""


class DdsService:
    """The serving end of a service, for each of its types."""

    def __init__(
        self,
        factory: Entities,
        dispatcher: Dispatcher,
        service: str,
        types: Sequence[ServiceTypes],
        on_request: OnRequest,
    ) -> None:
        with ExitStack() as opened:
            for each in types:
                end = _Endpoint(factory, dispatcher, service, each, on_request)
                opened.callback(end.close)
            self._opened = opened.pop_all()

    def close(self) -> None:
        """Serve no more."""
        self._opened.close()


class _End(ABC):
    """A reader and a writer of a service."""

    def __init__(
        self, service: str, writer: DataWriter[Any], reader: DataReader[Any]
    ) -> None:
        self._service = service
        self._writer = writer
        self._reader = reader
        self._lock = threading.Lock()
        self._closed = False
        self._condition = entities.condition(reader)
        self._entries: list[Entry] = []
        self._waiting: dict[Hashable, tuple[int, Future[bytes]]] = {}
        """The server of each request under way; a server has none."""

    @abstractmethod
    def _received(self, octets: bytes, writer: int) -> None:
        """Process a request or reply of the writer with this handle."""

    def _start(self, dispatcher: Dispatcher) -> None:
        self._entries.append(dispatcher.add(self._condition, self._take))

    def _take(self) -> None:
        for octets, info in entities.taken(self._reader):
            if info.valid_data:
                self._received(octets, info.publication_handle)

    def close(self) -> None:
        """Delete reader and writer. A second call has no effect."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._fail("the client is closed")
        for entry in self._entries:
            entry.close()
        with self._lock:
            for entity in (self._condition, self._reader, self._writer):
                entities.delete(entity)

    def _fail(self, why: str, remaining: Collection[int] = ()) -> None:
        """End the calls whose servers do not remain."""
        with self._lock:
            waiting = list(self._waiting.values())
        for server, future in waiting:
            if server not in remaining and not future.done():
                future.set_exception(PeerLostError(why))


class DdsServer(_End):
    """A reader of requests and a writer of their replies."""

    def _reply(self, octets: bytes) -> None:
        with self._lock:
            if self._closed:
                return
            try:
                entities.write(self._writer, octets, _WRITE_TIMEOUT)
            except MediumError as error:
                log.warning("%s: a reply cannot be sent: %s", self._service, error)


class _Endpoint(DdsServer):
    def __init__(
        self,
        factory: Entities,
        dispatcher: Dispatcher,
        service: str,
        types: ServiceTypes,
        on_request: OnRequest,
    ) -> None:
        writer = factory.writer(f"{service}Reply", types.reply, _REPLIES, _LATE)
        reader = factory.reader(f"{service}Request", types.request, _QOS, _OURS)
        super().__init__(service, writer, reader)
        self._on_request = on_request
        self._name = reader.guid.hex
        self._start(dispatcher)

    def _received(self, octets: bytes, writer: int) -> None:
        try:
            if server_of(octets) in ("", self._name):
                self._on_request(octets, self._reply)
        except CdrError as error:
            log.warning("%s: a request cannot be decoded: %s", self._service, error)


class Request(NamedTuple):
    """A request as sent, and the handle of its server."""

    identity: Hashable
    server: int
    octets: bytes


class DdsClient(_End):
    """A writer of requests and a reader of their replies; see `medium.Client`."""

    def __init__(
        self, service: str, writer: DataWriter[Any], reader: DataReader[Any]
    ) -> None:
        super().__init__(service, writer, reader)
        self._times_cancelled = 0
        writer.set_status_mask(DDSStatus.PublicationMatched)

    @abstractmethod
    def _request(self, octets: bytes, deadline: float) -> Request:
        """Return a request for a server. Raises NotServedError, PeerLostError."""

    @abstractmethod
    def _answer(self, octets: bytes, writer: int) -> tuple[Hashable, bytes] | None:
        """Return the identity and the octets of a reply; None for one that is none."""

    @abstractmethod
    def _servers(self) -> Collection[int]:
        """Return the handles of the servers that are there."""

    def _start(self, dispatcher: Dispatcher) -> None:
        super()._start(dispatcher)
        self._entries.append(dispatcher.add(self._writer, self._matched_changed))

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`."""
        with self._while_open():
            return self._call(octets, timeout)

    def _call(self, octets: bytes, timeout: float) -> bytes:
        future: Future[bytes] = Future()
        deadline = time.monotonic() + timeout
        before = self._times_cancelled
        request = self._request(octets, deadline)
        with self._lock:
            self._check(before)
            self._waiting[request.identity] = request.server, future
        try:
            entities.write(self._writer, request.octets, timeout)
            self._matched_changed()  # The server may have been lost just before.
            return future.result(max(0.0, deadline - time.monotonic()))
        except FutureTimeout as error:
            message = f"no reply of {self._service} in {timeout} s"
            raise ReplyTimeoutError(message) from error
        finally:
            with self._lock:
                self._waiting.pop(request.identity, None)

    def send(self, octets: bytes, timeout: float) -> None:
        """See `medium.Client`."""
        with self._while_open():
            request = self._request(octets, time.monotonic() + timeout)
            entities.write(self._writer, request.octets, timeout)

    @contextmanager
    def _while_open(self) -> Iterator[None]:
        """What fails since `close` has deleted the entities is a PeerLostError."""
        try:
            with entities.reported(self._service):
                yield
        except MediumError as error:
            if self._closed:
                message = f"the client of {self._service} is closed"
                raise PeerLostError(message) from error
            raise

    def _check(self, times_cancelled: int) -> None:
        """Raise PeerLostError after `close`, or a further `cancel`."""
        if self._closed:
            raise PeerLostError(f"the client of {self._service} is closed")
        if self._times_cancelled != times_cancelled:
            raise PeerLostError(f"the call of {self._service} is cancelled")

    def cancel(self) -> None:
        """See `medium.Client`."""
        with self._lock:
            self._times_cancelled += 1
        self._fail(f"the call of {self._service} is cancelled")

    def _matched_changed(self) -> None:
        writer: Any = self._writer
        with self._lock:
            if self._closed:
                return
            writer.get_publication_matched_status()  # or the condition stays true
            servers = self._servers()
        self._fail(f"the server of {self._service} was lost", servers)

    def _received(self, octets: bytes, writer: int) -> None:
        answer = self._answer(octets, writer)
        if answer is None:
            return
        identity, reply = answer
        with self._lock:
            _, future = self._waiting.pop(identity, (0, None))
        if future is not None and not future.done():
            future.set_result(reply)


class DdsRpcClient(DdsClient):
    """The calling end of a service of DDS-RPC."""

    def __init__(
        self,
        factory: Entities,
        dispatcher: Dispatcher,
        service: str,
        types: ServiceTypes,
    ) -> None:
        writer = factory.writer(f"{service}Request", types.request, _QOS)
        reader = factory.reader(f"{service}Reply", types.reply, _REPLIES)
        super().__init__(service, writer, reader)
        self._names: dict[int, str] = {}
        """The names of servers, by the handles of their readers."""
        self._start(dispatcher)

    def _request(self, octets: bytes, deadline: float) -> Request:
        """Return a request for a server that is found in a short time.

        A server of rtgen is named, so that no other one takes the request. Others get it without a
        name, as DDS-RPC has it for a service with one server.
        """
        identity = identity_of(octets)
        deadline = min(deadline, time.monotonic() + _DISCOVERY)
        while (connected := self._server()) is None:
            if time.monotonic() > deadline:
                raise NotServedError(f"nobody serves {self._service}")
            time.sleep(0.002)
        server, name = connected
        return Request(identity, server, directed(octets, name) if name else octets)

    def _server(self) -> tuple[int, str] | None:
        """Return the handle of a server's reader, and its name, empty for one without rtgen.

        None if there is no server whose replies are received. Raises PeerLostError.
        """
        with self._lock:
            self._check(self._times_cancelled)
            if not entities.matched(self._reader):
                return None
            for server in sorted(entities.matched(self._writer)):
                name = self._names.get(server)
                if name is None and (name := self._name(server)) is not None:
                    self._names[server] = name
                if name is not None:
                    return server, name
        return None

    def _name(self, server: int) -> str | None:
        """Return the name of a server; None if it is lost."""
        reader = entities.counterpart(self._writer, server)
        if reader is None:
            return None
        return reader.guid.hex() if reader.user_data == _OURS else ""

    def _servers(self) -> Collection[int]:
        servers = set(entities.matched(self._writer))
        self._names = {h: self._names[h] for h in self._names.keys() & servers}
        return servers

    def _answer(self, octets: bytes, writer: int) -> tuple[Hashable, bytes] | None:
        try:
            return identity_of(octets), octets
        except CdrError as error:
            log.warning("%s: a reply cannot be decoded: %s", self._service, error)
            return None
