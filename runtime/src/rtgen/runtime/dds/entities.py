"""Readers and writers of one participant: QoS, partition, samples as octets."""

from __future__ import annotations

import ctypes
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from cyclonedds import _clayer
from cyclonedds.core import (
    DDSException,
    InstanceState,
    ReadCondition,
    SampleState,
    ViewState,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.internal import dds_c_t
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.qos import Policy, _CQos
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic

from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.medium import (
    MediumError,
    PublishTimeoutError,
    Qos,
    representation,
)

ANY = SampleState.Any | ViewState.Any | InstanceState.Any
_SECOND = 1_000_000_000
_AT_ONCE = 256
"""Maximum samples taken at a time, and initial number of requested handles."""
_MAX_UNREAD = 1024
"""Samples that a reader keeps at most before it slows its writers down."""
_TIMEOUT = -10

_batch = _CQos._dll_handle.dds_qset_writer_batching
_batch.argtypes, _batch.restype = (dds_c_t.qos_p, ctypes.c_bool), None
_flush = ctypes.PYFUNCTYPE(dds_c_t.returnv, dds_c_t.entity)(
    ("dds_write_flush", _CQos._dll_handle)
)
"""Keeps Python's lock, as cyclonedds does while it writes: others would get it for a time slice."""


@contextmanager
def reported(what: str) -> Iterator[None]:
    """Turn errors of cyclonedds into MediumError; some of them are bare exceptions."""
    try:
        yield
    except (DDSException, TypeError) as error:
        raise MediumError(f"{what}: {error}") from error
    except Exception as error:
        if type(error) is not Exception:
            raise
        raise MediumError(f"{what}: {error}") from error


class Endpoint(NamedTuple):
    """A reader or writer of any process: the octets of its GUID, and its user data."""

    guid: bytes
    user_data: bytes


def matched(end: DataWriter[Any] | DataReader[Any]) -> list[int]:
    """Return the handles of the readers or writers that an end is matched with.

    cyclonedds's own wrappers request the number first, and fail if it grows before the second call.
    Raises DDSException.
    """
    entity: Any = end
    get: Callable[..., int] = (
        entity._get_matched_subscriptions
        if isinstance(end, DataWriter)
        else entity._get_matched_publications
    )
    room = _AT_ONCE
    while True:
        handles = (dds_c_t.instance_handle * room)()
        first = ctypes.cast(handles, ctypes.POINTER(dds_c_t.instance_handle))
        count = get(entity._ref, first, room)
        if count < 0:
            raise DDSException(count)
        if count <= room:
            return handles[:count]
        room = count


def counterpart(end: DataWriter[Any] | DataReader[Any], handle: int) -> Endpoint | None:
    """Return the reader or writer with this handle; None if it is no longer matched."""
    look = (
        _clayer.ddspy_get_matched_subscription_data
        if isinstance(end, DataWriter)
        else _clayer.ddspy_get_matched_publication_data
    )
    endpoint: Endpoint | None = look(end._ref, handle, _endpoint, _user_data)
    return endpoint


def _endpoint(guid: bytes, *described: Any) -> Endpoint:
    """Return an endpoint from cyclonedds's values, the third last of which is its QoS."""
    return Endpoint(guid, described[-3])


def _user_data(qos: int) -> bytes:
    """Return the user data of a QoS of C.

    cyclonedds's own conversion uses variables shared by all threads, so one gets the user data of
    another, and it does not free them.
    """
    data, size = ctypes.c_void_p(), ctypes.c_size_t()
    place = ctypes.cast(qos, dds_c_t.qos_p)
    if not _CQos._get_userdata(place, ctypes.byref(data), ctypes.byref(size)):
        return b""
    try:
        return ctypes.string_at(data, size.value) if data else b""
    finally:
        _CQos.free(data)


class _BatchingWriter(DataWriter[Any]):
    """A writer with a policy that cyclonedds has no Python class for."""

    def _create_writer(self, owner: Any, topic: Any, qos: Any, listener: Any) -> Any:
        _batch(qos, True)
        return super()._create_writer(owner, topic, qos, listener)


class Entities:
    """Makes the readers and writers of a participant in one partition."""

    def __init__(self, participant: DomainParticipant, partition: str) -> None:
        self._participant = participant
        scope = DdsQos(Policy.Partition([partition]))
        self._publisher = Publisher(participant, scope)
        self._subscriber = Subscriber(participant, scope)
        self._topics: dict[tuple[str, int], tuple[Topic[Any], Any]] = {}
        self._lock = threading.Lock()

    def writer(
        self,
        name: str,
        type_: type[Any],
        qos: Qos,
        late: int | None = None,
        *,
        batching: bool = False,
    ) -> DataWriter[Any]:
        """Return a writer of a topic. Raises MediumError.

        `late`: number of samples for readers created later, if durable; default `qos.depth`.
        `batching`: samples are sent by `flush`, or when a datagram is full.
        """
        kind = _BatchingWriter if batching else DataWriter
        with reported(f"the writer of {name}"):
            policies = [*_policies(qos, late), _sent(type_)]
            return kind(self._publisher, self._topic(name, type_), DdsQos(*policies))

    def reader(
        self, name: str, type_: type[Any], qos: Qos, user_data: bytes = b""
    ) -> DataReader[Any]:
        """A reader of a topic; others see its user data. Raises MediumError."""
        with reported(f"the reader of {name}"):
            policies = [*_policies(qos), Policy.DataRepresentation(True, True)]
            if user_data:
                policies.append(Policy.Userdata(user_data))
            if qos.depth is None:
                policies.append(Policy.ResourceLimits(_MAX_UNREAD, -1, -1))
            return DataReader(
                self._subscriber, self._topic(name, type_), DdsQos(*policies)
            )

    def _topic(self, name: str, type_: type[Any]) -> Topic[Any]:
        class_ = idl_class(type_)
        with self._lock:
            cached = self._topics.get((name, id(class_)))
            if cached is None:
                cached = Topic(self._participant, name, class_), class_
                self._topics[name, id(class_)] = cached
            return cached[0]


def _policies(qos: Qos, late: int | None = None) -> list[Any]:
    reliable = Policy.Reliability.Reliable(0)
    policies: list[Any] = [
        reliable if qos.reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if qos.durable else Policy.Durability.Volatile,
        _history(qos.depth),
    ]
    if qos.durable:
        history = _history(late or qos.depth)
        policies.append(Policy.DurabilityService(0, history, -1, -1, -1))
    if qos.deadline is not None:
        policies.append(Policy.Deadline(round(qos.deadline * _SECOND)))
    if qos.lease is not None:
        policies.append(Policy.Liveliness.Automatic(round(qos.lease * _SECOND)))
    return policies


def _history(depth: int | None) -> Any:
    return Policy.History.KeepAll if depth is None else Policy.History.KeepLast(depth)


def _sent(type_: type[Any]) -> Any:
    version = representation(type_).version
    return Policy.DataRepresentation(version == 1, version == 2)


def alive(lease: float | None) -> list[Any]:
    """Return the policies of a participant with this lease [s]; None for that of its domain."""
    if lease is None:
        return []
    return [Policy.Liveliness.Automatic(round(lease * _SECOND))]


def condition(reader: DataReader[Any]) -> ReadCondition:
    """True while the reader has samples that were not taken."""
    return ReadCondition(reader, ANY)


def taken(reader: DataReader[Any]) -> Iterator[tuple[bytes, Any]]:
    """Take all samples, each with cyclonedds's information on it."""
    while True:
        samples = _clayer.ddspy_take(reader._ref, ANY, _AT_ONCE)
        if isinstance(samples, int):
            raise MediumError(f"samples cannot be taken: {DDSException(samples).msg}")
        yield from samples
        if len(samples) < _AT_ONCE:
            return


def write(
    writer: DataWriter[Any], octets: bytes | bytearray, patience: float = 0.0
) -> None:
    """Write a serialized sample; wait for space for at most that number of seconds.

    cyclonedds does not release Python's lock while it writes, so a write must not wait itself.
    There is room once all readers have acknowledged what they were sent: a write that is only
    tried would copy the sample each time. Raises PublishTimeoutError, MediumError.
    """
    code = _clayer.ddspy_write(writer._ref, octets)
    if code == _TIMEOUT and patience > 0:
        deadline = time.monotonic() + patience
        while code == _TIMEOUT and (remaining := deadline - time.monotonic()) > 0:
            writer._wait_for_acks(writer._ref, round(remaining * _SECOND))
            code = _clayer.ddspy_write(writer._ref, octets)
    if code == _TIMEOUT:
        raise PublishTimeoutError(f"no room for a sample of {writer.topic.name}")
    if code < 0:
        raise MediumError(f"{writer.topic.name}: {DDSException(code).msg}")


def flush(writer: DataWriter[Any]) -> None:
    """Send what a batching writer holds. A deleted writer has sent everything."""
    _flush(writer._ref)


def delete(entity: Any) -> None:
    """Delete an entity of cyclonedds now, not when Python forgets it."""
    entity.__del__()
