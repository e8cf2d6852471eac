"""Requests and replies of service calls as octets, the same over every engine.

Request: identity of the client (16 octets), number of the call (8), byte order and whether it is
oneway (1), length of the operation's name (2), the name in UTF-8, the body. Reply: status (1),
byte order (1), the body. Numbers are little-endian. Bodies are those of
`rtgen.runtime.services.calls`.
"""

from __future__ import annotations

import struct
from collections import OrderedDict
from dataclasses import dataclass

from rtgen.runtime.services.calls import Reply, ReplyStatus

_HEAD = struct.Struct("<16sQBH")
_LITTLE, _ONEWAY = 1, 2
_REMEMBERED = 4096
"""Requests that are known again if they come twice."""

LONGEST_OPERATION = 1024
"""Octets of the name of an operation."""


class EnvelopeError(ValueError):
    """The octets are not request, or no reply."""


@dataclass(frozen=True, slots=True)
class Request:
    """A request as received; `client` and `number` identify it."""

    client: bytes
    number: int
    operation: str
    body: bytes
    little_endian: bool
    oneway: bool


def request_octets(request: Request) -> bytes:
    """The octets of a request."""
    name = request.operation.encode()
    flags = _LITTLE * request.little_endian | _ONEWAY * request.oneway
    head = _HEAD.pack(request.client, request.number, flags, len(name))
    return head + name + request.body


def read_request(octets: bytes) -> Request:
    """The request of octets. Raises EnvelopeError."""
    try:
        client, number, flags, length = _HEAD.unpack_from(octets)
        name = octets[_HEAD.size : _HEAD.size + length]
        if len(name) != length or length > LONGEST_OPERATION:
            raise EnvelopeError("the name of the operation is cut off or too long")
        operation = name.decode()
    except (struct.error, UnicodeDecodeError) as error:
        raise EnvelopeError(str(error)) from error
    body = octets[_HEAD.size + length :]
    little, oneway = bool(flags & _LITTLE), bool(flags & _ONEWAY)
    return Request(client, number, operation, body, little, oneway)


def reply_octets(reply: Reply | None) -> bytes:
    """The octets of a reply; of None, for a oneway call, an empty result."""
    if reply is None:
        return bytes((ReplyStatus.NO_EXCEPTION, True))
    return bytes((reply.status, reply.little_endian)) + reply.body


def read_reply(octets: bytes) -> Reply:
    """The reply of octets. Raises EnvelopeError."""
    if len(octets) < 2:
        raise EnvelopeError("the reply is cut off")
    try:
        return Reply(ReplyStatus(octets[0]), octets[2:], bool(octets[1]))
    except ValueError as error:
        raise EnvelopeError(str(error)) from error


class Doubles:
    """Recognizes requests that were received before; the oldest are forgotten."""

    def __init__(self) -> None:
        self._seen: OrderedDict[tuple[bytes, int], None] = OrderedDict()

    def is_double(self, request: Request) -> bool:
        """Whether the request was seen before; from one thread at a time."""
        key = request.client, request.number
        if key in self._seen:
            return True
        self._seen[key] = None
        if len(self._seen) > _REMEMBERED:
            self._seen.popitem(last=False)
        return False
