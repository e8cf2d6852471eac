"""Contract of messaging engines (DDS, Zenoh), by which systems run in several processes.

An engine is a `Medium`; data ports, service calls, presence and control are implemented once above
it (`rtgen.runtime.distribution.transport`). A medium connects one process with one system: the
systems of a network do not see each other (a partition, a prefix of key expressions). The part of
it that ROS 2 has, too, is `Messaging`, which each engine also implements with the names of ROS 2
(`rtgen.runtime.ros2`): those are fully qualified, and services have the headers of its middleware.

Names consist of letters, digits, `_`, `-` and `/`, at most 200 characters, and do not begin or end
with `/`. Topics, services and presences have separate name spaces.

Callbacks (`on_sample`, `on_request`, `on_change`) are called in threads of the engine, or in that
of a sender in the same process; for one subscription, service or watch by one thread at a time.
They return soon and raise nothing. After `close` of their subscription, service or watch, at most
the current call ends.

Octets of samples are serialized payloads with their encapsulation header of four octets (DDSI-RTPS
2.5, 10.2) in the form that `representation` gives, so that programs without rtgen can decode them;
received ones have any form. So are the octets of requests and replies, whose types begin with the
headers of DDS-RPC (`rpc_header`): the identity of a request, which its reply repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any, Protocol, TypeAlias, TypeVar

import msgspec

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    DataType,
    MapDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.xcdr import Representation, representation_of

MAX_NAME_LENGTH = 200
"""Maximum number of characters of a name."""

SEQUENCES = 1 << 32
"""Sequence numbers of samples: the one after the highest is 0."""


class MediumError(Exception):
    """The engine cannot work as configured; the message says why."""


class NotServedError(MediumError):
    """Nobody serves the service: the call was not carried out."""


class PublishTimeoutError(MediumError):
    """No room for a sample within `Qos.patience`: it was not sent."""


class PeerLostError(MediumError):
    """The server was lost before its reply: the call may have been carried out."""


class ReplyTimeoutError(MediumError):
    """No reply in time: the call may have been carried out, or be in progress."""


class Topic(msgspec.Struct, frozen=True):
    """A topic of samples: its name, and the generated type, whose `_descriptor_` describes it."""

    name: str
    type: type[DataType]


class ServiceTypes(msgspec.Struct, frozen=True):
    """The types of the requests and replies of a service."""

    request: Any
    reply: Any


class Qos(msgspec.Struct, frozen=True, gc=False):
    """Quality of service of a publisher (offered) or a subscription (requested).

    `reliable`: samples are sent again until they arrive; `depth`: samples that the engine keeps for
    each publisher, None for all of them: a slow subscription then slows the publisher down, which
    waits for at most `patience` seconds, and its `on_sample` may wait itself;
    `durable`: the last `depth` samples are sent to subscriptions that come later, as long as the
    publisher lives; `deadline`: the longest time between two samples in seconds, None for any;
    `lease`: seconds without a sign of life after which a publisher counts as lost, None for the
    engine's own.
    """

    reliable: bool = True
    depth: int | None = 8
    patience: float = 1.0
    durable: bool = False
    deadline: float | None = None
    lease: float | None = None


class Sample(msgspec.Struct, frozen=True):
    """A sample as received.

    `source` identifies the publisher; a restarted process has new ones. `sequence`
    numbers its samples one by one, modulo `SEQUENCES`, so that lost ones are counted; None for
    publishers that do not number them.
    """

    octets: bytes
    source: Hashable
    sequence: int | None = None


OnSample: TypeAlias = Callable[[Sample], None]
Reply: TypeAlias = Callable[[bytes], None]
"""Sends the reply to a request, once, from any thread; without effect if the client is gone."""
OnRequest: TypeAlias = Callable[[bytes, Reply], None]
OnChange: TypeAlias = Callable[[str, bool], None]
"""A name whose presence begins (True) or ends (False)."""


class Publisher(Protocol):
    """The sending end of a topic."""

    def publish(self, octets: bytes, /) -> None:
        """Send a sample.

        From any thread, one at a time, and not during `close`. Waits only if `depth` is None: then
        it raises PublishTimeoutError after `patience`. Raises MediumError.
        """

    @property
    def matched(self) -> bool:
        """Whether a subscription is known; samples of a durable publisher need none."""

    def close(self) -> None:
        """Withdraw the publisher."""


class Subscription(Protocol):
    """The receiving end of a topic."""

    @property
    def lost(self) -> int:
        """Samples that the engine knows to have lost, if it carries no sequence numbers; else 0."""

    @property
    def missed_deadlines(self) -> int:
        """How many periods of `Qos.deadline` passed without a sample, from the first one on."""

    def close(self) -> None:
        """Receive no more samples."""


class Client(Protocol):
    """The calling end of a service."""

    def call(self, octets: bytes, timeout: float) -> bytes:
        """Send a request and wait for its reply for at most `timeout` seconds; from any thread.

        A request is delivered to one server, at most once, and never repeated. Raises
        NotServedError if there is no server, PeerLostError if the server is lost meanwhile (an
        engine that does not notice raises ReplyTimeoutError), and ReplyTimeoutError.
        """

    def send(self, octets: bytes, timeout: float) -> None:
        """Send a oneway request to one server, at most once; a reply is ignored.

        `timeout` [s] until it is sent. Raises NotServedError, MediumError.
        """

    def cancel(self) -> None:
        """Make calls under way raise PeerLostError; later ones are carried out."""

    def close(self) -> None:
        """Calls under way raise PeerLostError."""


class Token(Protocol):
    """Something that lasts until it is closed: a service, a presence, a watch."""

    def close(self) -> None:
        """End it. A second call has no effect."""


_Topic = TypeVar("_Topic", bound=Topic, contravariant=True)
_Qos = TypeVar("_Qos", bound=Qos, contravariant=True)
_Types = TypeVar("_Types", bound=ServiceTypes, contravariant=True)


class Messaging(Protocol[_Topic, _Qos, _Types]):
    """One process's topics and services on a network. Methods raise MediumError."""

    def publisher(self, topic: _Topic, qos: _Qos) -> Publisher:
        """A publisher of a topic; other processes find it by themselves."""

    def subscribe(self, topic: _Topic, qos: _Qos, on_sample: OnSample) -> Subscription:
        """Receive the samples of all publishers of a topic, each publisher's in their order.

        Publishers whose type or offered QoS does not fit are not received.
        """

    def serve(
        self, service: str, types: Sequence[_Types], on_request: OnRequest
    ) -> Token:
        """Serve a service. `on_request` hands the work to another thread and returns.

        Of several `types` the first one has the operations of all; clients may use any of them.
        """

    def client(self, service: str, types: _Types) -> Client:
        """A client of a service, which need not exist yet and may come and go."""

    def close(self) -> None:
        """End everything of this process. A second call has no effect."""


class Medium(Messaging[Topic, Qos, ServiceTypes], Protocol):
    """One process's part in one system, over one engine. Methods raise MediumError."""

    def announce(self, name: str) -> Token:
        """Show other processes that something is present, until the token is closed.

        If this process ends in any way they notice, at the latest after the engine's lease.
        """

    def watch(self, prefix: str, on_change: OnChange) -> Token:
        """Notify of names that begin with a prefix: first of those present, then of each change.

        A presence announced by two processes ends with the last of them. Names announced by this
        process are reported, too.
        """


def check_name(name: str) -> str:
    """The name, if it is one that every engine takes. Raises MediumError."""
    plain = name.isascii() and all(c.isalnum() or c in "_-/" for c in name)
    if not plain or not name or name != name.strip("/") or len(name) > MAX_NAME_LENGTH:
        raise MediumError(
            f"{name!r} cannot be a name between processes: letters, digits, '_', '-' and '/', "
            f"at most {MAX_NAME_LENGTH} characters"
        )
    return name


def check_lease(topic: Topic, qos: Qos, own: float | None) -> None:
    """Raise MediumError for a publisher with a shorter lease than that of its process.

    `own` [s] is that of the process; None if it is not known.
    """
    if qos.lease is not None and (own is None or qos.lease < own):
        stated = "that of its configuration" if own is None else f"{own:g} s"
        raise MediumError(
            f"{topic.name}: a lease of {qos.lease:g} s is requested, but that of the process is "
            f"{stated}; it is set when the medium is opened"
        )


def representation(type_: type[Any]) -> Representation:
    """In which form samples of a type are sent, little-endian.

    Plain XCDR1, which every DDS reads, and ROS 2 writes; XCDR2 for types with appendable or mutable
    parts or optional members, for which XCDR1 has forms that few implement.
    """
    version = 1 if _is_plain(type_._descriptor_, set()) else 2
    return representation_of(type_, version)


def _is_plain(descriptor: Any, seen: set[str]) -> bool:
    descriptor = plain(descriptor)
    match descriptor:
        case StructDescriptor() | UnionDescriptor():
            if descriptor.repository_id in seen:
                return True
            seen.add(descriptor.repository_id)
            parts = (
                descriptor.members
                if isinstance(descriptor, StructDescriptor)
                else descriptor.branches
            )
            return descriptor.extensibility == "final" and all(
                not getattr(part, "optional", False) and _is_plain(part.type, seen)
                for part in parts
            )
        case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
            return _is_plain(element, seen)
        case MapDescriptor():
            return _is_plain(descriptor.value, seen)
    return True


def type_name(type_: type[Any]) -> str:
    """The name of a topic's type in IDL, with `::` between modules."""
    return str(type_._descriptor_.name)
