"""Requests and responses over DDS, compatible with rmw_cyclonedds: a header before each message.

The header has the number of the client and that of the request, each 8 octets in the byte order of
the message. A server returns it unchanged.
"""

from __future__ import annotations

import os
import struct
import threading
import time
from collections.abc import Callable
from itertools import count
from typing import Any, Protocol

from rtgen.facts.ros_names import RequestId
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.failures import log
from rtgen.runtime.services.servants import (
    CallEnded,
    CallTimeout,
    CommunicationFailure,
    ObjectNotExist,
)

_CDR = 4
_LITTLE, _BIG = struct.Struct("<Qq"), struct.Struct(">Qq")
_POLL_INTERVAL = 0.005
_CHECK_INTERVAL = 0.5
"""Seconds after which a waiting call checks whether its server still exists."""
_READER_TIMEOUT = 2.0
"""Seconds that a server waits for the reader of an unknown client."""

Write = Callable[[bytes], None]
Matched = Callable[[], bool]


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


class Server:
    """The replies of a service."""

    def __init__(self, name: str, write: Write) -> None:
        self._name = name
        self._write = write

    def take(self, octets: bytes, reads: Matched, on_request: Any) -> None:
        """Dispatch a request with a function for replies; `reads`: its client reads replies."""
        try:
            request, message = split(octets)
        except ValueError as error:
            log.warning("%s: %s", self._name, error)
            return
        on_request(message, lambda response: self._reply(request, reads, response))

    def _reply(self, request: RequestId, reads: Matched, response: bytes) -> None:
        deadline = time.monotonic() + _READER_TIMEOUT
        while not reads() and time.monotonic() < deadline:
            time.sleep(_POLL_INTERVAL)
        self._write(joined(request, response))


class Servers(Protocol):
    """The servers of a service, as its client knows them."""

    def available(self) -> bool:
        """Return whether one is known, with both its ends. Raises MediumError."""

    def check(self, timeout: float) -> None:
        """Raise ServiceError if a request must not be written, within the time-out [s].

        Raises MediumError.
        """


class Client:
    """The requests of a client."""

    def __init__(self, name: str, write: Write, servers: Servers) -> None:
        self._name = name
        self._write = write
        self._servers = servers
        self._own = int.from_bytes(os.urandom(8), "little")
        self._numbers = count(1)
        self._changed = threading.Condition()
        self._waiting: dict[int, bytes | None] = {}
        self._ended: set[int] = set()
        """Numbers of calls that the end of the run has ended."""
        self._closed = False

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `services.Call`."""
        deadline = time.monotonic() + timeout
        number = next(self._numbers)
        with self._changed:
            self._waiting[number] = None
        try:
            self._wait_for_server(number, deadline)
            self._write(joined(RequestId(self._own, number), octets))
            return self._response(number, deadline)
        except MediumError as error:
            # The network may have been closed meanwhile.
            raise CommunicationFailure(f"{self._name}: {error}") from error
        finally:
            with self._changed:
                del self._waiting[number]
                self._ended.discard(number)

    def _wait_for_server(self, number: int, deadline: float) -> None:
        """Wait until a request can be written."""
        while True:
            self._check_open(number)
            is_available = self._servers.available()
            self._servers.check(max(0.0, deadline - time.monotonic()))
            if is_available:
                return
            if time.monotonic() > deadline:
                raise ObjectNotExist(f"nobody serves {self._name}")
            time.sleep(_POLL_INTERVAL)

    def _response(self, number: int, deadline: float) -> bytes:
        with self._changed:
            while True:
                response = self._waiting[number]
                if response is not None:
                    return response
                self._check_open(number)
                left = deadline - time.monotonic()
                if left <= 0:
                    raise CallTimeout(f"no response of {self._name}")
                if not self._servers.available():
                    raise CommunicationFailure(f"{self._name} is served no more")
                self._changed.wait(min(left, _CHECK_INTERVAL))

    def _check_open(self, number: int) -> None:
        if number in self._ended:
            raise CallEnded(f"the run ended while a call of {self._name} waited")
        if self._closed:
            raise CommunicationFailure(f"the client of {self._name} is closed")

    def take(self, octets: bytes) -> None:
        """Process a response, which may be that of another client."""
        try:
            request, message = split(octets)
        except ValueError as error:
            log.warning("%s: %s", self._name, error)
            return
        with self._changed:
            if request.client == self._own and request.sequence in self._waiting:
                self._waiting[request.sequence] = message
                self._changed.notify_all()

    def end_calls(self) -> None:
        """Make calls in progress raise CallEnded."""
        with self._changed:
            self._ended.update(self._waiting)
            self._changed.notify_all()

    def close(self) -> None:
        """Close the client; calls in progress raise CommunicationFailure."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
