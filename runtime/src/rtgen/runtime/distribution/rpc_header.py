"""Headers of requests and replies, by DDS-RPC 1.0 (7.5.1.1.1), for every engine.

Both begin with the identity of the request, 24 octets after the encapsulation header; in a request,
the name of the server follows, empty for any.
"""

from __future__ import annotations

import os
import struct
import threading
from collections import OrderedDict
from collections.abc import Callable
from enum import IntEnum
from itertools import count
from typing import ClassVar, TypeAlias

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, CdrError, field
from rtgen.runtime.distribution.medium import (
    Medium,
    OnRequest,
    Reply,
    ServiceTypes,
    Token,
    representation,
)
from rtgen.runtime.distribution.payloads import received
from rtgen.runtime.failures import log
from rtgen.runtime.xcdr import serialize

_MAX_REMEMBERED = 4096
"""Number of requests whose duplicates are detected."""

Identity: TypeAlias = tuple[bytes, int]
"""A client, and the number of its request."""


class RemoteExceptionCode(IntEnum):
    """Reasons of failed calls outside of the interface (DDS-RPC 1.0, 7.5.1.1.1)."""

    REMOTE_EX_OK = 0
    REMOTE_EX_UNSUPPORTED = 1
    REMOTE_EX_INVALID_ARGUMENT = 2
    REMOTE_EX_OUT_OF_RESOURCES = 3
    REMOTE_EX_UNKNOWN_OPERATION = 4
    REMOTE_EX_UNKNOWN_EXCEPTION = 5


idl.enum(RemoteExceptionCode, "dds::rpc::RemoteExceptionCode_t")


class EntityId(Aggregated):
    """The last part of a GUID."""

    _descriptor_: ClassVar = idl.struct(
        "dds::EntityId_t",
        entity_key=idl.member(idl.array(idl.OCTET, 3), name="entityKey"),
        entity_kind=idl.member(idl.OCTET, name="entityKind"),
    )

    entity_key: bytes = bytes(3)
    entity_kind: int = 0


class Guid(Aggregated):
    """A globally unique identifier of DDS."""

    _descriptor_: ClassVar = idl.struct(
        "dds::GUID_t",
        guid_prefix=idl.member(idl.array(idl.OCTET, 12), name="guidPrefix"),
        entity_id=idl.member(EntityId, name="entityId"),
    )

    guid_prefix: bytes = bytes(12)
    entity_id: EntityId = field(default_factory=EntityId)


class SequenceNumber(Aggregated):
    """A number in two halves."""

    _descriptor_: ClassVar = idl.struct(
        "dds::SequenceNumber_t", high=idl.LONG, low=idl.UNSIGNED_LONG
    )

    high: int = 0
    low: int = 0


class SampleIdentity(Aggregated):
    """The identity of a request."""

    _descriptor_: ClassVar = idl.struct(
        "dds::SampleIdentity",
        writer_guid=Guid,
        sequence_number=SequenceNumber,
    )

    writer_guid: Guid = field(default_factory=Guid)
    sequence_number: SequenceNumber = field(default_factory=SequenceNumber)


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
    """The header of a reply."""

    _descriptor_: ClassVar = idl.struct(
        "dds::rpc::ReplyHeader",
        related_request_id=idl.member(SampleIdentity, name="relatedRequestId"),
        remote_ex=idl.member(RemoteExceptionCode, name="remoteEx"),
    )

    related_request_id: SampleIdentity = field(default_factory=SampleIdentity)
    remote_ex: RemoteExceptionCode = RemoteExceptionCode.REMOTE_EX_OK


class Identities:
    """Assigns identities to the requests of a client."""

    def __init__(self) -> None:
        client = os.urandom(16)
        self._guid = Guid(client[:12], EntityId(client[12:15], client[15]))
        self._numbers = count(1)

    def header(self) -> RequestHeader:
        """Return the header of the next request."""
        number = SequenceNumber(0, 0)
        number.high, number.low = divmod(next(self._numbers), 1 << 32)
        return RequestHeader(SampleIdentity(self._guid, number), "")


_PLAIN = (0, 1, 6, 7)
"""Encapsulations with this form of header: CDR and plain XCDR2."""
_NAME = 4 + 24
_NAMELESS = bytes((1, 0, 0, 0)) + bytes(4)
_MAX_NAME = 256


def identity_of(octets: bytes) -> Identity:
    """Return the identity at the beginning of a request or reply. Raises CdrError."""
    order = _order(octets)
    client, high, low = struct.unpack_from(f"{order}16siI", octets, 4)
    return client, high << 32 | low


def server_of(octets: bytes) -> str:
    """Return the name of the server of a request; empty for any. Raises CdrError."""
    order = _order(octets)
    (length,) = struct.unpack_from(f"{order}I", octets, _NAME)
    name = octets[_NAME + 4 : _NAME + 4 + length]
    if not 0 < length <= _MAX_NAME or len(name) != length:
        raise CdrError("RequestHeader", "the name of the server is cut off or too long")
    return name[:-1].decode(errors="replace")


def directed(octets: bytes, server: str) -> bytes:
    """Return a request for a server whose name has 32 characters, which keep the alignment."""
    assert len(server) == 32
    assert octets[_NAME : _NAME + 8] == _NAMELESS
    name = struct.pack("<I33s3x", 33, server.encode())
    return octets[:_NAME] + name + octets[_NAME + 8 :]


def _order(octets: bytes) -> str:
    if len(octets) < _NAME + 4 or octets[0] or octets[1] not in _PLAIN:
        raise CdrError("SampleIdentity", "there is no header of DDS-RPC")
    return "<" if octets[1] & 1 else ">"


class Doubles:
    """Detects duplicate requests; the oldest are forgotten."""

    def __init__(self) -> None:
        self._seen: OrderedDict[Identity, None] = OrderedDict()
        self._lock = threading.Lock()

    def is_double(self, identity: Identity) -> bool:
        """Return whether the request was seen before."""
        with self._lock:
            if identity in self._seen:
                return True
            self._seen[identity] = None
            if len(self._seen) > _MAX_REMEMBERED:
                self._seen.popitem(last=False)
            return False


# Services whose requests and replies are octets.


class OctetsRequest(Aggregated):
    """A request."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::OctetsRequest", header=RequestHeader, data=idl.sequence(idl.OCTET)
    )

    header: RequestHeader = field(default_factory=RequestHeader)
    data: bytes = b""


class OctetsReply(Aggregated):
    """A reply."""

    _descriptor_: ClassVar = idl.struct(
        "rtgen::OctetsReply", header=ReplyHeader, data=idl.sequence(idl.OCTET)
    )

    header: ReplyHeader = field(default_factory=ReplyHeader)
    data: bytes = b""


_OCTETS = ServiceTypes(OctetsRequest, OctetsReply)


OnOctets: TypeAlias = Callable[[bytes, bytes, Reply], None]
"""The client, by its GUID, its request, and the reply."""


def serve_octets(medium: Medium, name: str, on_request: OnRequest) -> Token:
    """Serve a service whose requests and replies are octets. Raises MediumError."""
    return serve_clients(medium, name, lambda _, data, reply: on_request(data, reply))


def serve_clients(medium: Medium, name: str, on_request: OnOctets) -> Token:
    """Serve such a service, knowing the clients. Raises MediumError."""

    def on_octets(octets: bytes, reply: Reply) -> None:
        try:
            request = received(OctetsRequest, octets)
        except CdrError as error:
            log.warning("%s: a request cannot be decoded: %s", name, error)
            return
        client, _ = identity_of(octets)
        on_request(client, bytes(request.data), _replying(request.header, reply))

    return medium.serve(name, (_OCTETS,), on_octets)


def _replying(header: RequestHeader, reply: Reply) -> Callable[[bytes], None]:
    def send(octets: bytes) -> None:
        answer = OctetsReply(
            ReplyHeader(header.request_id, RemoteExceptionCode.REMOTE_EX_OK), octets
        )
        reply(serialize(answer, representation(OctetsReply)))

    return send


class OctetsClient:
    """A client of such a service. Raises MediumError."""

    def __init__(self, medium: Medium, name: str) -> None:
        self._client = medium.client(name, _OCTETS)
        self._identities = Identities()

    def call(self, octets: bytes, timeout: float) -> bytes:
        """See `medium.Client`. Raises CdrError for a wrong reply."""
        request = OctetsRequest(self._identities.header(), octets)
        sent = serialize(request, representation(OctetsRequest))
        return bytes(received(OctetsReply, self._client.call(sent, timeout)).data)

    def cancel(self) -> None:
        """See `medium.Client`."""
        self._client.cancel()

    def close(self) -> None:
        """See `medium.Client`."""
        self._client.close()
