"""Services as pairs of topics, by the basic mapping of DDS-RPC 1.0 (7.5.1).

A service has the topics `<service>Request` and `<service>Reply`. Each sample begins with the header
of the specification (7.5.1.1.1): the identity of the request, which its reply repeats. What follows
is not a type for each operation but a sequence of octets, which the layer above fills.

Replies are transient-local, so that a reply is not lost to a client whose reader the server has not
discovered yet.
"""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from functools import partial
from itertools import count
from typing import Any, ClassVar

from cyclonedds.core import DDSStatus

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, CdrError, field
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.entities import Entities
from rtgen.runtime.distribution.medium import (
    NotServedError,
    OnRequest,
    PeerLostError,
    Qos,
    ReplyTimeoutError,
    representation,
)
from rtgen.runtime.failures import log
from rtgen.runtime.xcdr import deserialize, serialize

_DISCOVERY = 0.25
"""Seconds that a call waits for a server to be discovered."""
_QOS = Qos(depth=64)
_REPLIES = Qos(depth=16, durable=True)


class SampleIdentity(Aggregated):
    """The identity of a request: a GUID of DDS, and a number (DDS-RPC 1.0, 7.5.1.1.1)."""

    _descriptor_: ClassVar = idl.struct(
        "dds::SampleIdentity",
        writer_guid=idl.array(idl.OCTET, 16),
        high=idl.LONG,
        low=idl.UNSIGNED_LONG,
    )

    writer_guid: bytes = bytes(16)
    high: int = 0
    low: int = 0


class RequestHeader(Aggregated):
    """The header of a request; `instance_name` selects one of several servers, or is empty."""

    _descriptor_: ClassVar = idl.struct(
        "dds::rpc::RequestHeader",
        request_id=idl.member(SampleIdentity, name="requestId"),
        instance_name=idl.member(idl.string(255), name="instanceName"),
    )

    request_id: SampleIdentity = field(default_factory=SampleIdentity)
    instance_name: str = ""


class ReplyHeader(Aggregated):
    """The header of a reply; `remote_ex` is 0 for REMOTE_EX_OK."""

    _descriptor_: ClassVar = idl.struct(
        "dds::rpc::ReplyHeader",
        related_request_id=idl.member(SampleIdentity, name="relatedRequestId"),
        remote_ex=idl.member(idl.LONG, name="remoteEx"),
    )

    related_request_id: SampleIdentity = field(default_factory=SampleIdentity)
    remote_ex: int = 0


class Request(Aggregated):
    """A request."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Request", header=RequestHeader, data=idl.sequence(idl.OCTET)
    )

    header: RequestHeader = field(default_factory=RequestHeader)
    data: bytes = b""


class Reply(Aggregated):
    """A reply."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::Reply", header=ReplyHeader, data=idl.sequence(idl.OCTET)
    )

    header: ReplyHeader = field(default_factory=ReplyHeader)
    data: bytes = b""


class DdsService:
    """The serving end of a service."""

    def __init__(
        self,
        made: Entities,
        dispatcher: Dispatcher,
        service: str,
        on_request: OnRequest,
    ) -> None:
        self._service = service
        self._on_request = on_request
        self._writer = made.writer(f"{service}Reply", Reply, _REPLIES)
        self._reader = made.reader(f"{service}Request", Request, _QOS)
        self._sending = threading.Lock()
        self._closed = False
        self._condition = entities.condition(self._reader)
        self._entry = dispatcher.add(self._condition, self._take)

    def close(self) -> None:
        """Serve no more."""
        with self._sending:
            if self._closed:
                return
            self._closed = True
        self._entry.close()
        for entity in (self._condition, self._reader, self._writer):
            entities.delete(entity)

    def _take(self) -> None:
        for octets, info in entities.taken(self._reader):
            if info.valid_data:
                self._received(octets)

    def _received(self, octets: bytes) -> None:
        try:
            request = deserialize(Request, octets)
        except CdrError as error:
            log.warning("%s: a request cannot be decoded: %s", self._service, error)
            return
        reply = partial(self._reply, request.header.request_id)
        self._on_request(bytes(request.data), reply)

    def _reply(self, identity: SampleIdentity, octets: bytes) -> None:
        reply = Reply(ReplyHeader(identity, 0), octets)
        sample = serialize(reply, representation(Reply))
        with self._sending:
            if not self._closed:
                entities.write(self._writer, sample)


class DdsClient:
    """The calling end of a service; see `medium.Client`."""

    def __init__(self, made: Entities, dispatcher: Dispatcher, service: str) -> None:
        self._service = service
        self._writer = made.writer(f"{service}Request", Request, _QOS)
        self._reader = made.reader(f"{service}Reply", Reply, _REPLIES)
        self._guid = self._writer.guid.bytes
        self._numbers = count(1)
        self._waiting: dict[int, Future[bytes]] = {}
        self._lock = threading.Lock()
        self._closed = False
        self._writer.set_status_mask(DDSStatus.PublicationMatched)
        self._condition = entities.condition(self._reader)
        self._entries = [
            dispatcher.add(self._condition, self._take),
            dispatcher.add(self._writer, self._matched_changed),
        ]

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`."""
        number = next(self._numbers)
        future: Future[bytes] = Future()
        identity = SampleIdentity(self._guid, number >> 32, number & 0xFFFFFFFF)
        request = Request(RequestHeader(identity, ""), octets)
        sample = serialize(request, representation(Request))
        deadline = time.monotonic() + timeout
        self._await_server(min(timeout, _DISCOVERY))
        with self._lock:
            if self._closed:
                raise PeerLostError(f"the client of {self._service} is closed")
            self._waiting[number] = future
        try:
            entities.write(self._writer, sample, timeout)
            return future.result(max(0.0, deadline - time.monotonic()))
        except FutureTimeout as error:
            message = f"no reply of {self._service} in {timeout} s"
            raise ReplyTimeoutError(message) from error
        finally:
            with self._lock:
                self._waiting.pop(number, None)

    def close(self) -> None:
        """See `medium.Client`."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._fail("the client is closed")
        for entry in self._entries:
            entry.close()
        for entity in (self._condition, self._reader, self._writer):
            entities.delete(entity)

    def _await_server(self, seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while not self._served():
            if time.monotonic() > deadline:
                raise NotServedError(f"nobody serves {self._service}")
            time.sleep(0.002)

    def _served(self) -> bool:
        """Whether a server takes requests, and its replies come here."""
        with self._lock:
            if self._closed:
                raise PeerLostError(f"the client of {self._service} is closed")
            return bool(
                self._writer.get_matched_subscriptions()
                and self._reader.get_matched_publications()
            )

    def _matched_changed(self) -> None:
        writer: Any = self._writer
        status = writer.get_publication_matched_status()
        if status.current_count == 0:
            self._fail(f"the server of {self._service} was lost")

    def _fail(self, why: str) -> None:
        with self._lock:
            waiting = list(self._waiting.values())
        for future in waiting:
            if not future.done():
                future.set_exception(PeerLostError(why))

    def _take(self) -> None:
        for octets, info in entities.taken(self._reader):
            if info.valid_data:
                self._received(octets)

    def _received(self, octets: bytes) -> None:
        try:
            reply = deserialize(Reply, octets)
        except CdrError as error:
            log.warning("%s: a reply cannot be decoded: %s", self._service, error)
            return
        identity = reply.header.related_request_id
        if bytes(identity.writer_guid) != self._guid:
            return
        with self._lock:
            future = self._waiting.pop(identity.high << 32 | identity.low, None)
        if future is not None and not future.done():
            future.set_result(bytes(reply.data))
