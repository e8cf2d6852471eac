"""Services over DDS as in rmw_cyclonedds: a header before each request and response.

The header has the number of the client and that of the request, each 8 octets in the byte order of
the message. A server returns it unchanged. A request reaches all servers.
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Collection, Hashable
from functools import partial
from itertools import count
from typing import Any

from cyclonedds.core import DDSStatus
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from rtgen.facts.ros_names import RequestId
from rtgen.runtime.dds import entities
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.rpc import DdsClient, DdsServer, Request
from rtgen.runtime.distribution.medium import NotServedError, OnRequest
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.dds_ends import CLIENT, SERVER, Ends, Strangers

_CDR = 4
_LITTLE, _BIG = struct.Struct("<Qq"), struct.Struct(">Qq")
_POLL_INTERVAL = 0.005
_READER_TIMEOUT = 2.0
"""Seconds that a server waits for the reader of an unknown client."""
_ALL = 0
"""Stands for the handle of a server: a request is for all of them."""


def split(octets: bytes) -> tuple[RequestId, bytes]:
    """Split octets into header and message with encapsulation header. Raises ValueError."""
    form = _LITTLE if octets[1:2] == b"\x01" else _BIG
    if len(octets) < _CDR + form.size:
        raise ValueError(f"{len(octets)} octets are not a request")
    request = RequestId(*form.unpack_from(octets, _CDR))
    return request, octets[:_CDR] + octets[_CDR + form.size :]


def joined(request: RequestId, octets: bytes) -> bytes:
    """Return a little-endian message with a header."""
    return octets[:_CDR] + _LITTLE.pack(*request) + octets[_CDR:]


class Server(DdsServer):
    """The serving end of a service."""

    def __init__(
        self,
        service: str,
        writer: DataWriter[Any],
        reader: DataReader[Any],
        strangers: Strangers,
        on_request: OnRequest,
        dispatcher: Dispatcher,
    ) -> None:
        super().__init__(service, writer, reader)
        self._strangers = strangers
        self._on_request = on_request
        self._clients = Ends(reader, CLIENT)
        self._readers = Ends(writer, CLIENT)
        self._start(dispatcher)
        with entities.reported(service):
            reader.set_status_mask(DDSStatus.SubscriptionMatched)
        self._entries.append(dispatcher.add(reader, self._matched_changed))

    def _matched_changed(self) -> None:
        with entities.reported(self._service):
            self._reader.take_status(DDSStatus.SubscriptionMatched)
        self._strangers.discovered(self._service, CLIENT, self._clients.all())

    def _received(self, octets: bytes, writer: int) -> None:
        client = self._clients.find(writer)
        if client is None:
            log.debug("%s: a request of an unknown client", self._service)
        elif client.id is None:
            self._strangers.report(self._service, CLIENT, client.guid)
        elif (parts := _parts(self._service, octets)) is not None:
            request, message = parts
            self._on_request(message, partial(self._respond, request, client.id))

    def _respond(self, request: RequestId, client: str, response: bytes) -> None:
        deadline = time.monotonic() + _READER_TIMEOUT
        while not self._readers.have(client) and time.monotonic() < deadline:
            time.sleep(_POLL_INTERVAL)
        self._reply(joined(request, response))


class Client(DdsClient):
    """The calling end of a service, whose servers read its requests and write the responses."""

    def __init__(
        self,
        service: str,
        writer: DataWriter[Any],
        reader: DataReader[Any],
        strangers: Strangers,
        dispatcher: Dispatcher,
    ) -> None:
        super().__init__(service, writer, reader)
        self._strangers = strangers
        self._readers = Ends(writer, SERVER)
        self._writers = Ends(reader, SERVER)
        self._own = int.from_bytes(os.urandom(8), "little")
        self._numbers = count(1)
        self._start(dispatcher)

    def _request(self, octets: bytes, deadline: float) -> Request:
        """Return a request as soon as there is a server, and no stranger would get it, too."""
        before = self._times_cancelled
        while True:
            self._check(before)
            servers = self._servers()
            self._check_strangers(max(0.0, deadline - time.monotonic()))
            if servers:
                break
            if time.monotonic() > deadline:
                raise NotServedError(f"nobody serves {self._service}")
            time.sleep(_POLL_INTERVAL)
        identity = RequestId(self._own, next(self._numbers))
        return Request(identity, _ALL, joined(identity, octets))

    def _servers(self) -> Collection[int]:
        """Return `_ALL` if there is a server with both ends."""
        ends = self._readers.all()
        self._strangers.discovered(self._service, SERVER, ends)
        replying = {end.id for end in self._writers.all()} - {None}
        return (_ALL,) if replying.intersection(end.id for end in ends) else ()

    def _check_strangers(self, timeout: float) -> None:
        """Raise NotServedError if a request would reach a stranger, within the time-out [s]."""
        for end in self._readers.all():
            if end.id is None:
                if not self._strangers.has_reported(self._service, end.guid):
                    self._strangers.wait_for_node(end.guid, timeout)
                why = self._strangers.report(self._service, SERVER, end.guid)
                raise NotServedError(why)

    def _answer(self, octets: bytes, writer: int) -> tuple[Hashable, bytes] | None:
        server = self._writers.find(writer)
        if server is None or server.id is None:
            return None
        return _parts(self._service, octets)


def _parts(service: str, octets: bytes) -> tuple[RequestId, bytes] | None:
    """Return header and message; None for octets without a header, which are reported."""
    try:
        return split(octets)
    except ValueError as error:
        log.warning("%s: %s", service, error)
        return None
