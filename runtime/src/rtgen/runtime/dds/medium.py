"""A medium over Eclipse Cyclone DDS: one participant, a partition for each system."""

from __future__ import annotations

import re
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar
from xml.sax.saxutils import quoteattr, unescape

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Qos as DdsQos
from cyclonedds.sub import DataReader

from rtgen.facts.files import UnreadableError, read_file
from rtgen.runtime.dds import c_log, entities
from rtgen.runtime.dds.bursts import Burst, Sender
from rtgen.runtime.dds.dispatcher import Dispatcher
from rtgen.runtime.dds.entities import Entities
from rtgen.runtime.dds.numbers import DOUBLE, WRITERS, Numbers, numbered, plain
from rtgen.runtime.dds.presence import Presences
from rtgen.runtime.dds.rpc import DdsClient, DdsRpcClient, DdsService
from rtgen.runtime.distribution.key_files import check_key_file
from rtgen.runtime.distribution.medium import (
    MediumError,
    OnChange,
    OnRequest,
    OnSample,
    Qos,
    Sample,
    ServiceTypes,
    Token,
    Topic,
    check_lease,
    check_name,
)
from rtgen.runtime.freed_memory import keep_freed_memory

_T = TypeVar("_T", bound=Token)

LEASE = 2.0
"""Seconds without a sign of life after which a process counts as lost."""
_ANNOUNCED = 5.0
"""Seconds between announcements of a participant: one that stood still is found again after that.

Cyclone's own 30 s is long for a process that was stopped for longer than its lease.
"""

_RECEIVED = '<SocketReceiveBufferSize max="16 MiB"/>'
"""The system's limit applies; what finds no room is sent again."""
_DATAGRAMS = (
    "<MaxMessageSize>65500 B</MaxMessageSize><FragmentSize>63000 B</FragmentSize>"
    if sys.platform == "linux"
    else ""
)
"""As large as loopback carries; a network would divide them, and not every system sends them."""
_RESENT = """<MaxQueuedRexmitBytes>4 MB</MaxQueuedRexmitBytes>
<BurstSize><MaxRexmit>4 MB</MaxRexmit></BurstSize><NackDelay>1ms</NackDelay>
<HeartbeatInterval min="5ms" minsched="5ms" max="8s">10ms</HeartbeatInterval>"""
"""What a reader missed is asked for at once, and sent again in one go.

Large datagrams overflow the receive buffer of a Fast DDS reader, 208 KiB by default, which asks
every 5 ms: with Cyclone's 512 kB each answer, half a message of 10 MB took ten rounds. It asks when
a heartbeat tells it of the message: if that one is lost too, the next came after 100 ms.
"""
_COMPATIBILITY = (
    "<Compatibility><IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>"
)
"""Cyclone refuses readers and writers of Fast DDS 3 (vendor 1.15) by their type information."""
_LOOPBACK = f"""<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast>{_DATAGRAMS}</General>{_COMPATIBILITY}
<Internal>{_RECEIVED}{_RESENT}</Internal>
<Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex>
<LeaseDuration>{{lease}}s</LeaseDuration><SPDPInterval>{{announced}}s</SPDPInterval>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""
_INTERFACE = f"""<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface {{kind}}={{name}}/></Interfaces></General>{_COMPATIBILITY}
<Internal>{_RECEIVED}</Internal>
<Discovery><LeaseDuration>{{lease}}s</LeaseDuration>
<SPDPInterval>{{announced}}s</SPDPInterval></Discovery></Domain></CycloneDDS>"""


def configuration(
    interface: str | None, lease: float = LEASE, announced: float = _ANNOUNCED
) -> str:
    """The configuration of Cyclone DDS for an interface, by name or address.

    None is loopback: unicast among at most 100 participants of this machine. `announced`: seconds
    between the announcements of a participant.
    """
    if interface is None:
        return _LOOPBACK.format(lease=lease, announced=announced)
    kind = "address" if interface[:1].isdigit() or ":" in interface else "name"
    return _INTERFACE.format(
        kind=kind, name=quoteattr(interface), lease=lease, announced=announced
    )


class _Domains:
    """The domains of this process: cyclonedds configures each once."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: dict[int, tuple[Domain, str, int]] = {}

    def open(self, number: int, config: str) -> None:
        """Open a domain once more. Raises MediumError."""
        with self._lock:
            domain = self._open.get(number)
            if domain is None:
                domain = _created(number, config), config, 0
            elif domain[1] != config:
                raise MediumError(f"domain {number} is open with other options")
            self._open[number] = *domain[:2], domain[2] + 1

    def close(self, number: int) -> None:
        """Close it once; the last time it ends."""
        with self._lock:
            domain, config, users = self._open.pop(number)
            if users > 1:
                self._open[number] = domain, config, users - 1
            else:
                with c_log.closing():
                    entities.delete(domain)


def _created(number: int, config: str) -> Domain:
    """Return a domain; what the C library says is a part of the error. Raises MediumError."""
    messages: list[str] = []
    try:
        with c_log.logged() as messages, entities.reported(f"domain {number}"):
            return Domain(number, config)
    except MediumError as error:
        if messages:
            why = "; ".join(messages)
            raise MediumError(f"domain {number}: {why}") from error
        raise


DOMAINS = _Domains()
"""The domains of all media of this process."""


class DdsEngine:
    """One process's participant in a domain. Raises MediumError.

    `config` is Cyclone DDS's configuration of the domain; `policies` are those of the participant.
    """

    def __init__(self, domain: int, config: str, *policies: Any) -> None:
        keep_freed_memory()
        self._domain = domain
        self._closed = False
        self._open: list[Token] = []
        self._lock = threading.Lock()
        DOMAINS.open(domain, config)
        participant: DomainParticipant | None = None
        try:
            with entities.reported(f"domain {domain}"):
                qos = DdsQos(*policies)
                participant = self._participant = DomainParticipant(domain, qos=qos)
                self._data = Dispatcher(self._participant, "rtgen dds data")
                self._control = Dispatcher(self._participant, "rtgen dds control")
        except MediumError:
            if participant is not None:
                entities.delete(participant)
            DOMAINS.close(domain)
            raise

    @contextmanager
    def _closing_on_error(self) -> Iterator[None]:
        """Report errors of cyclonedds, and close what is open after one."""
        try:
            with entities.reported(f"domain {self._domain}"):
                yield
        except MediumError:
            self.close()
            raise

    def close(self) -> None:
        """See `Messaging`."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            opened, self._open = self._open, []
        for entity in reversed(opened):
            entity.close()
        self._data.close()
        self._control.close()
        entities.delete(self._participant)
        DOMAINS.close(self._domain)

    def _keep(self, token: _T) -> _T:
        """Return a token, which is closed with the engine at the latest."""
        with self._lock:
            if not self._closed:
                self._open.append(token)
                return token
        token.close()
        raise MediumError("the medium is closed")


class DdsMedium(DdsEngine):
    """See `rtgen.runtime.distribution.medium.Medium`. Raises MediumError.

    `system` is the partition; `domain` 0 to 232; `interface` by name or address, loopback by
    default; `config` a file of Cyclone DDS in place of these, with its interfaces and security.
    `lease`: after so many seconds without a sign of life others count the process as lost, by
    default `LEASE` or what the file says.
    """

    def __init__(
        self,
        system: str,
        *,
        domain: int = 0,
        interface: str | None = None,
        config: Path | None = None,
        lease: float | None = None,
    ) -> None:
        text = configuration(interface) if config is None else _read(config)
        super().__init__(domain, text, *entities.alive(lease))
        self._lease = LEASE if config is None and lease is None else lease
        with self._closing_on_error():
            self._made = Entities(self._participant, system)
            self._presences = self._keep(Presences(self._made, self._control))
            self._sender = self._keep(Sender())

    def publisher(self, topic: Topic, qos: Qos) -> DdsPublisher:
        """See `Medium`. The lease of the process cannot be shortened later."""
        check_lease(topic, qos, self._lease)
        name = check_name(topic.name)
        writer = self._made.writer(name, topic.type, qos, batching=True)
        return self._keep(NumberedPublisher(writer, self._sender, qos))

    def subscribe(self, topic: Topic, qos: Qos, on_sample: OnSample) -> DdsSubscription:
        """See `Medium`."""
        name = check_name(topic.name)
        dispatcher = self._data
        if qos.depth is None:
            dispatcher = self._keep(Dispatcher(self._participant, f"rtgen dds {name}"))
        reader = self._made.reader(name, topic.type, qos)
        return self._keep(DdsSubscription(reader, dispatcher, on_sample))

    def serve(
        self, service: str, types: Sequence[ServiceTypes], on_request: OnRequest
    ) -> Token:
        """See `Medium`."""
        name = check_name(service)
        return self._keep(
            DdsService(self._made, self._control, name, types, on_request)
        )

    def client(self, service: str, types: ServiceTypes) -> DdsClient:
        """See `Medium`."""
        name = check_name(service)
        return self._keep(DdsRpcClient(self._made, self._control, name, types))

    def announce(self, name: str) -> Token:
        """See `Medium`."""
        with entities.reported(name):
            return self._keep(_Once(self._presences.announce(check_name(name))))

    def watch(self, prefix: str, on_change: OnChange) -> Token:
        """See `Medium`."""
        return self._keep(_Once(self._presences.watch(prefix, on_change)))


_KEY_FILE = re.compile(r"<(\w+)>\s*file:([^<]*[^<\s])")
"""An element that names a file of DDS Security (DDS Security 1.1, 9.3 and 9.4)."""


def _read(config: Path) -> str:
    try:
        text = read_file(config).decode("ascii")
    except (UnreadableError, UnicodeDecodeError) as error:
        raise MediumError(f"{config} cannot be read: {error}") from error
    for key, name in _KEY_FILE.findall(text):
        check_key_file(str(config), key, Path(unescape(name)))
    return text


class _Once:
    """A token that calls a function at its first `close`."""

    def __init__(self, end: Callable[[], None]) -> None:
        self._end: Callable[[], None] | None = end

    def close(self) -> None:
        end, self._end = self._end, None
        if end is not None:
            end()


class DdsPublisher:
    """See `medium.Publisher`: a writer, whose samples wait for room for `patience` seconds."""

    def __init__(self, writer: DataWriter[Any], patience: float) -> None:
        self._writer = writer
        self._patience = patience
        self._closed = False

    def publish(self, octets: bytes) -> None:
        """See `medium.Publisher`."""
        if self._closed:
            raise MediumError("the publisher is closed")
        entities.write(self._writer, octets, self._patience)

    @property
    def matched(self) -> bool:
        """See `medium.Publisher`."""
        if self._closed:
            return False
        with entities.reported(self._writer.topic.name):
            return bool(entities.matched(self._writer))

    def close(self) -> None:
        """See `medium.Publisher`."""
        if not self._closed:
            self._closed = True
            entities.delete(self._writer)


class NumberedPublisher(DdsPublisher):
    """A publisher of rtgen, which numbers its samples and sends those of a burst together."""

    def __init__(self, writer: DataWriter[Any], sender: Sender, qos: Qos) -> None:
        super().__init__(writer, qos.patience if qos.depth is None else 0.0)
        self._burst = Burst(writer, sender, qos.depth)
        self._sequence = 0

    def publish(self, octets: bytes) -> None:
        """See `medium.Publisher`. A sample that finds no room leaves its number to the next."""
        if self._closed:
            raise MediumError("the publisher is closed")
        sequence = self._sequence + 1
        entities.write(self._writer, numbered(octets, sequence), self._patience)
        self._sequence = sequence
        self._burst.written()


class DdsSubscription:
    """See `medium.Subscription`: a reader of samples, which rtgen has numbered."""

    def __init__(
        self,
        reader: DataReader[Any],
        dispatcher: Dispatcher,
        on_sample: OnSample,
        *,
        are_numbered: bool = True,
    ) -> None:
        self._on_sample = on_sample
        self._closed = False
        self._missed = 0
        self._numbers = Numbers() if are_numbered else None
        self._writers: OrderedDict[int, Hashable] = OrderedDict()
        self._reader = reader
        self._condition = entities.condition(reader)
        self._entry = dispatcher.add(self._condition, self._take)

    @property
    def lost(self) -> int:
        """0: samples carry numbers."""
        return 0

    @property
    def missed_deadlines(self) -> int:
        """See `medium.Subscription`."""
        if not self._closed:
            reader: Any = self._reader
            status = reader.get_requested_deadline_missed_status()
            self._missed = int(status.total_count)
        return self._missed

    def close(self) -> None:
        """See `medium.Subscription`."""
        if not self._closed:
            self._entry.close()
            self._missed = self.missed_deadlines
            self._closed = True
            entities.delete(self._condition)
            entities.delete(self._reader)

    def _take(self) -> None:
        for octets, info in entities.taken(self._reader):
            if info.valid_data:
                handle = info.publication_handle
                source = self._writers.get(handle) or self._writer(handle)
                if self._numbers is None:
                    self._on_sample(Sample(octets, source))
                    continue
                stamp = info.source_timestamp
                sequence = self._numbers.sequence(source, octets, stamp)
                if sequence != DOUBLE:
                    sent = octets if sequence is None else plain(octets)
                    self._on_sample(Sample(sent, source, sequence))

    def _writer(self, handle: int) -> Hashable:
        """The identity of a writer, which gets a new handle when it is found again."""
        endpoint = entities.counterpart(self._reader, handle)
        writer: Hashable = handle if endpoint is None else endpoint.guid
        self._writers[handle] = writer
        if len(self._writers) > WRITERS:
            self._writers.popitem(last=False)
        return writer
