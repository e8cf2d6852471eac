"""Data ports, which a component reads and writes, and the connectors between them.

A sample belongs to one side at a time: `write` takes a snapshot, so the writer can reuse its
object, and the result of `read` belongs to the reader. A writer that passes its sample on with
`move=True` saves the snapshot.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, ClassVar, Generic, TypeVar

from rtgen.facts.connector_properties import (
    Dataflow,
    EmptyPolicy,
    FullPolicy,
    Subscription,
)
from rtgen.facts.value_checks import CheckValues, count_of
from rtgen.runtime.errors import (
    ConnectionLimitError,
    DuplicateConnectionError,
    PortTypeError,
    SampleTypeError,
)
from rtgen.runtime.marshalling.comparison import difference
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.marshalling.errors import CdrError
from rtgen.runtime.marshalling.layouts.formats import UnsupportedError
from rtgen.runtime.marshalling.reference_counts import COUNTS_VARIABLES
from rtgen.runtime.ports import connector_properties
from rtgen.runtime.ports.buffers import RingBuffer
from rtgen.runtime.ports.in_c import module
from rtgen.runtime.ports.publisher import Publisher
from rtgen.runtime.return_codes import PORT_OK, PortStatus
from rtgen.runtime.timing.guards import SINGLE_THREAD, Guard

T = TypeVar("T", bound=DataType)

_NOTHING: deque[Any] = deque(maxlen=0)

_SOLE_REFERENCES = 3 if COUNTS_VARIABLES else 0
"""Number of references to a sample that only one variable of the writer refers to, in `write`.

0 if it is not known: then each reader gets a snapshot. It is not measured, since a debugger can add
references meanwhile.
"""


class InPort(Generic[T]):
    """The receiving end of data connections. Samples of several are read in order of arrival."""

    __slots__ = (
        "_arrivals",
        "_connectors",
        "_feed",
        "_guard",
        "_last",
        "_on_arrival",
        "_sole",
        "_spare",
        "_unread",
        "lost_when_cut",
        "name",
        "owner",
        "type",
    )

    def __init__(self, name: str, type_: type[T], owner: str = "") -> None:
        self.name = name
        self.type = type_
        self.owner = owner
        self._connectors: tuple[DataConnector[T], ...] = ()
        self._guard: Guard = SINGLE_THREAD
        self._last: T | None = None
        self.lost_when_cut = 0
        """Samples lost on connections that were removed."""
        self._arrivals: deque[RingBuffer[T]] | None = None
        self._on_arrival: Callable[[], None] | None = None
        self._feed: Callable[[], None] | None = None
        """Moves a sample into a buffer of this port, if one is waiting elsewhere."""
        # Fast path: the samples of the only buffer, if only one thread uses it.
        self._sole: deque[T] = _NOTHING
        self._unread: deque[Any] = _NOTHING
        self._spare: T | None = None
        """A sample that nobody refers to any more, of which `rtgen-speed` makes the next one."""

    def __repr__(self) -> str:
        return f"<InPort {self}: {self.type.__name__}>"

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"

    def is_new(self) -> bool:
        """Return whether there is an unread sample; unlike in OpenRTM, also for pull
        connections.
        """
        if self._unread:
            return True
        if self._feed is not None:
            self._feed()
        return bool(self._unread)

    def read(self) -> T | None:
        """Return the oldest unread sample.

        Without one, the empty policy of the first connection applies: `readback` (also without
        connection) returns the object of the last read again, None if there was none; `do_nothing`
        returns None; `block` waits for a sample in real time, then returns None. In simulated time
        no sample could arrive, so it returns None at once.
        """
        samples = self._sole
        if samples:
            self._last = value = samples.popleft()
            return value
        return self._read_guarded()

    def read_newest(self) -> T | None:
        """Return the newest unread sample, None if there is none; older ones count as read."""
        samples = self._sole
        if samples:
            self._last = value = samples.pop()
            if samples:
                samples.clear()
            return value
        with self._guard:
            newest = None
            while (buffer := self._oldest()) is not None:
                if len(self._unread) > 1:
                    buffer.drop()
                else:
                    self._last = newest = buffer.take()
            self._guard.notify_all()
        return newest

    @property
    def connectors(self) -> tuple[DataConnector[T], ...]:
        """The connections, oldest first."""
        return self._connectors

    @property
    def last(self) -> T | None:
        """The sample read last; None before the first."""
        return self._last

    @property
    def lost(self) -> int:
        """Number of lost samples: overwritten, refused, dropped, or unread at disconnection."""
        return self.lost_when_cut + sum(
            connector.lost for connector in self._connectors
        )

    @property
    def unread(self) -> int:
        """Number of unread samples."""
        return len(self._unread)

    def call_on_arrival(self, action: Callable[[], None]) -> None:
        """Call a function after each sample that comes, in the tick and thread of its writer.

        Not for samples that this port fetches when it is read.
        """
        self._on_arrival = action
        self._rewire()

    def _read_guarded(self) -> T | None:
        with self._guard:
            buffer = self._oldest()
            settings = self._connectors[0].buffer.settings if self._connectors else None
            if (
                buffer is None
                and settings
                and settings.empty_policy is EmptyPolicy.BLOCK
            ):
                self._guard.wait_for(self.is_new, settings.read_timeout)
                buffer = self._oldest()
            if buffer is not None:
                self._last = value = buffer.take()
                self._guard.notify_all()
                return value
        if settings is None or settings.empty_policy is EmptyPolicy.READBACK:
            return self._last
        return None

    def _oldest(self) -> RingBuffer[T] | None:
        if not self.is_new():
            return None
        return self._arrivals[0] if self._arrivals else self._connectors[0].buffer

    def _protect(self, guard: Guard) -> None:
        self._guard = guard

    def _attach(self, connector: DataConnector[T]) -> None:
        with self._guard:
            self._connectors += (connector,)
            if self._arrivals is None:
                self._rewire()
            else:
                self._wire(connector)

    def _detach(self, connector: DataConnector[T]) -> None:
        with self._guard:
            self._connectors = _without(self._connectors, connector)
            self.lost_when_cut += connector.lost
            if len(self._connectors) < 2:
                self._rewire()

    def _rewire(self) -> None:
        buffers = [connector.buffer for connector in self._connectors]
        if len(buffers) > 1:
            if self._arrivals is None:
                self._arrivals = deque(
                    buffer for buffer in buffers for _ in buffer.samples
                )
            self._unread = self._arrivals
        else:
            self._arrivals = None
            self._unread = buffers[0].samples if buffers else _NOTHING
        alone = self._arrivals is None and self._guard is SINGLE_THREAD
        self._sole = buffers[0].samples if alone and buffers else _NOTHING
        for connector in self._connectors:
            self._wire(connector)

    def _wire(self, connector: DataConnector[T]) -> None:
        connector.buffer.arrivals = self._arrivals
        is_told = not connector.is_fetched
        connector.buffer.on_arrival = self._on_arrival if is_told else None
        connector.source._renew(connector)


class Demand(Enum):
    """Who reads the samples that an OutPort sends out of its process."""

    NOBODY = 0
    PAGES = 1
    """Readers that are no part of the run."""
    CONNECTION = 2


class OutPort(Generic[T]):
    """The sending end of data connections.

    Those of components check values; see `docs/runtime.md`, Values.
    """

    __slots__ = (
        "_check",
        "_connectors",
        "_outlets",
        "_record",
        "_short_ways",
        "_show",
        "_unchecked",
        "_ways",
        "_write",
        "name",
        "owner",
        "type",
        "unsent",
    )

    def __init__(self, name: str, type_: type[T], owner: str = "") -> None:
        self.name = name
        self.type = type_
        self.owner = owner
        self.unsent = 0
        """Samples written while there was no connection."""
        self._connectors: tuple[DataConnector[T], ...] = ()
        self._outlets: Mapping[Callable[[T], PortStatus], Callable[[], Demand]] = {}
        """Functions that send samples out of this process, and who reads them there."""
        self._record: Callable[[T], None] | None = None
        self._show: Callable[[T], None] | None = None
        """Shows samples to people; None if nobody watches."""
        self._short_ways: dict[DataConnector[T], Callable[[T], PortStatus]] = {}
        self._ways: tuple[Callable[[T], PortStatus], ...] = ()
        self._check = CheckValues.NEVER
        self._unchecked = count_of(self._check)
        """Number of values that have to be checked."""
        self._write: Callable[[T], PortStatus] = self._write_to_nobody

    def __repr__(self) -> str:
        return f"<OutPort {self}: {self.type.__name__}>"

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"

    def write(self, value: T, *, move: bool = False) -> PortStatus:
        """Send a snapshot of the sample over every connection.

        `move`: the writer passes on the sample with all that it contains, and does not use it any
        more, so one reader gets the object itself. A snapshot is sent nevertheless if more than one
        variable of the writer refers to the sample, if it was written before and has not been read,
        or if the interpreter does not count references exactly (CPython from 3.14 on).

        PORT_OK if all accepted it, else the status of the first that did not: BUFFER_FULL
        (`do_nothing`), BUFFER_TIMEOUT (`block`; at once in simulated time), CONNECTION_LOST;
        PRECONDITION_NOT_MET without connection. Raises SampleTypeError for another type, and
        CdrError for a value that is checked and that its type does not allow.
        """
        if move and _SOLE_REFERENCES and sys.getrefcount(value) <= _SOLE_REFERENCES:
            return self._write_moved(value)
        return self._write(value)

    def _write_moved(self, value: T) -> PortStatus:
        if value.__class__ is not self.type or not self._connectors or self._outlets:
            return self._write(value)
        if self._unchecked:
            self._check_value(value)
        return self._give(value)

    def check_values(self, check: CheckValues) -> None:
        """Set which values are checked from now on."""
        self._check, self._unchecked = check, count_of(check)
        self._rewire()

    def check_next(self) -> None:
        """Check the next value, if only some are checked."""
        if self._check is CheckValues.FIRST and not self._unchecked:
            self._unchecked = 1
            self._write = self._checking(self._write)

    def _checking(self, write: Callable[[T], PortStatus]) -> Callable[[T], PortStatus]:
        """Return the function that checks values, until it is replaced by `write`."""

        def write_checked(value: T) -> PortStatus:
            if not self._unchecked:
                self._write = write
            else:
                if value.__class__ is not self.type:
                    self._checked(value)
                self._check_value(value)
            return write(value)

        return write_checked

    def _check_value(self, value: T) -> None:
        """Raise CdrError for a value that could not be sent to another process."""
        try:
            value.to_cdr()
        except CdrError as error:
            raise self.located(error) from None
        except UnsupportedError:
            self._unchecked = 0  # values of this type never leave a process
            return
        self._unchecked -= 1

    def located(self, error: CdrError) -> CdrError:
        """Return the error of a value with the port in its path."""
        return CdrError(f"{self}: {error.path}", error.message)

    @property
    def connectors(self) -> tuple[DataConnector[T], ...]:
        """The connections, oldest first."""
        return self._connectors

    def offer(self, make: Callable[[], T]) -> None:
        """Write a sample that is only made for readers: a connection, or a page that shows it.

        Without a connection only pages get it, and neither recordings nor counts contain it, so a
        run is the same with and without a page.
        """
        demands = {way: demand() for way, demand in self._outlets.items()}
        if self._connectors or Demand.CONNECTION in demands.values():
            self.write(make())
            return
        shows: list[Callable[[T], object]] = [
            way for way, demand in demands.items() if demand is Demand.PAGES
        ]
        if self._show is not None:
            shows.append(self._show)
        if shows:
            value = make()
            for show in shows:
                show(value)

    def _observe(
        self,
        record: Callable[[T], None] | None,
        show: Callable[[T], None] | None = None,
    ) -> None:
        self._record, self._show = record, show
        self._rewire()

    def add_outlet(
        self,
        way: Callable[[T], PortStatus],
        demand: Callable[[], Demand] = lambda: Demand.CONNECTION,
    ) -> None:
        """Call a function with every sample, which remains the writer's; it must not raise.

        `demand` says who reads its samples now.
        """
        self._outlets = {**self._outlets, way: demand}
        self._rewire()

    def remove_outlet(self, way: Callable[[T], PortStatus]) -> None:
        """Stop calling the function."""
        self._outlets = {
            each: demand for each, demand in self._outlets.items() if each != way
        }
        self._rewire()

    def _attach(self, connector: DataConnector[T]) -> None:
        self._connectors += (connector,)
        self._short_ways[connector] = connector.short_way()
        self._rewire()

    def _detach(self, connector: DataConnector[T]) -> None:
        self._connectors = _without(self._connectors, connector)
        self._short_ways.pop(connector, None)
        self._rewire()

    def _renew(self, connector: DataConnector[T]) -> None:
        """Choose the way of a connector again, whose other end has changed."""
        if connector in self._short_ways:
            self._short_ways[connector] = connector.short_way()
            self._rewire()

    def _rewire(self) -> None:
        self._ways = (*self._short_ways.values(), *self._outlets)
        write: Callable[[T], PortStatus]
        if not self._ways:
            write = self._write_to_nobody
        elif len(self._ways) == 1:
            write = self._ways[0]
        else:
            write = self._write_to_all
        write = write if self._record is None else self._recorded(write)
        self._write = self._checking(write) if self._unchecked else write

    def _give(self, value: T) -> PortStatus:
        if self._record is not None:
            self._record(value)
        outcome = PORT_OK
        *others, last = self._connectors
        for connector in others:
            status = connector.send(value)
            if outcome is PORT_OK:
                outcome = status
        status = last.give(value)
        return status if outcome is PORT_OK else outcome

    def _write_to_nobody(self, value: T) -> PortStatus:
        self.unsent += 1
        return PortStatus.PRECONDITION_NOT_MET

    def _write_to_all(self, value: T) -> PortStatus:
        ways = self._ways
        if not ways:
            return self._write_to_nobody(value)
        outcome = PORT_OK
        for write in ways:
            status = write(value)
            if outcome is PORT_OK:
                outcome = status
        return outcome

    def _recorded(self, write: Callable[[T], PortStatus]) -> Callable[[T], PortStatus]:
        type_, record = self.type, self._record
        assert record is not None

        def write_recorded(value: T) -> PortStatus:
            if value.__class__ is not type_:
                self._checked(value)
            record(value)
            return write(value)

        return write_recorded

    def _checked(self, value: T) -> T:
        if not isinstance(value, self.type):
            raise SampleTypeError(
                f"{self} sends {self.type.__name__}, not {type(value).__name__}"
            )
        return value


class DataConnector(Generic[T]):
    """A connection of data ports, with counts of lost samples.

    `refused` writes returned a status, so the writer knows of them; `dropped` samples were skipped
    by the push policy; `cut` ones were unread when the connection was removed.
    """

    is_fetched: ClassVar[bool] = False
    """Whether the reader fetches the samples, so that none comes in the tick of its writer."""

    def __init__(
        self,
        name: str,
        source: OutPort[T],
        target: InPort[T],
        properties: Mapping[str, str],
        guard: Callable[[], Guard],
    ) -> None:
        self.name = name
        self.source = source
        self.target = target
        self.properties = dict(properties)
        self.settings = connector_properties.parse(properties)
        _check_types(source, target)
        _check_limits(self)
        pull = self.settings.dataflow is Dataflow.PULL
        end = self.settings.outport_buffer if pull else self.settings.inport_buffer
        self.buffer: RingBuffer[T] = RingBuffer(end, target._guard)
        self.publisher: Publisher[T] | None = None
        if not pull and self.settings.subscription is not Subscription.FLUSH:
            self.publisher = Publisher(self.settings, self.buffer, guard())
        self.refused = 0
        self.cut = 0
        self.connected = False
        self.why_missed = (
            "on the way from the other process; dataport.qos.depth keeps more of them"
        )
        """Where samples were lost that `missed` counts, and what to do."""
        self.deadline = self.properties.get("dataport.qos.deadline", "")
        """The deadline of samples from another process, in seconds."""
        self.end_publishing: Callable[[], None] = _do_nothing
        """Stops running the publisher; set by the scheduler that runs it."""
        self._snapshot = _snapshot_between(source.type, target.type)

    def __repr__(self) -> str:
        return f"<DataConnector {self.name}: {self.source} -> {self.target}>"

    @property
    def overwritten(self) -> int:
        """Number of samples overwritten in a full buffer."""
        sender = self.publisher.waiting.overwritten if self.publisher else 0
        return self.buffer.overwritten + sender

    @property
    def dropped(self) -> int:
        """Number of samples skipped by the push policy."""
        return self.publisher.dropped if self.publisher else 0

    @property
    def missed(self) -> int:
        """Number of samples from another process that were lost or could not be decoded."""
        return 0

    @property
    def missed_deadlines(self) -> int:
        """Number of times without a sample from another process within `dataport.qos.deadline`."""
        return 0

    @property
    def lost(self) -> int:
        """Number of all samples that did not reach the reader."""
        here = self.overwritten + self.refused + self.dropped + self.cut
        return here + self.missed

    @property
    def losses(self) -> dict[str, int]:
        """The numbers of lost samples by what became of them; without those that were cut."""
        counts = {
            "overwritten in a full buffer": self.overwritten,
            "refused by a full buffer": self.refused,
            "skipped by the push policy": self.dropped,
            "lost on the way from another process": self.missed,
        }
        return {what: count for what, count in counts.items() if count}

    def send(self, value: T) -> PortStatus:
        """Take a snapshot and deliver it, or leave it to the publisher."""
        return self._deliver(self._snapshot(self.source._checked(value)))

    def give(self, value: T) -> PortStatus:
        """Deliver a sample of the source's type that nothing else refers to."""
        if self.source.type is self.target.type:
            return self._deliver(value)
        return self._deliver(self._snapshot(value))

    def _deliver(self, sample: T) -> PortStatus:
        publisher = self.publisher
        if publisher is None:
            status = self.buffer.write(sample)
        else:
            status = publisher.waiting.write(sample)
            publisher.signal()
        if status is not PORT_OK:
            self.refused += 1
        return status

    def short_way(self) -> Callable[[T], PortStatus]:
        """Return the fastest form of `send` for the current connections; if in doubt, `send`."""
        buffer = self.buffer
        if (
            self.publisher is not None
            or buffer.guard is not SINGLE_THREAD
            or buffer.arrivals is not None
            or buffer.on_arrival is not None
        ):
            return self.send
        type_, length, snapshot = (
            self.source.type,
            buffer.settings.length,
            self._snapshot,
        )
        overwrites = buffer.settings.full_policy is FullPolicy.OVERWRITE
        samples, append, send = buffer.samples, buffer.samples.append, self.send
        drop = getattr(samples, "drop", samples.popleft)
        in_c = module(OutPort, InPort, _SOLE_REFERENCES)
        if in_c is not None:
            way: Callable[[T], PortStatus] = in_c.Way(
                type_,
                samples,
                length,
                overwrites,
                snapshot,
                send,
                buffer,
                drop,
                PORT_OK,
                self.target,
            )
            return way

        def write(value: T) -> PortStatus:
            if value.__class__ is not type_:
                return send(value)
            if len(samples) < length:
                append(snapshot(value))
                return PORT_OK
            if not overwrites:
                return send(value)
            sample = snapshot(value)
            drop()
            buffer.overwritten += 1
            append(sample)
            return PORT_OK

        return write

    def attach(self) -> None:
        """Establish the connection."""
        self.connected = True
        self.target._attach(self)
        self.source._attach(self)

    def detach(self) -> None:
        """Remove the connection; unread samples are dropped and counted."""
        self.connected = False
        self.source._detach(self)
        if self.publisher is not None:
            self.cut += self.publisher.waiting.close()
        self.cut += self.buffer.close()
        self.end_publishing()
        if self.publisher is not None:
            self.cut += self.publisher.in_hand
        self.target._detach(self)


def _without(
    connectors: tuple[DataConnector[T], ...], connector: DataConnector[T]
) -> tuple[DataConnector[T], ...]:
    if connector not in connectors:
        return connectors
    place = connectors.index(connector)
    return connectors[:place] + connectors[place + 1 :]


def _do_nothing() -> None:
    return None


def _check_types(source: OutPort[T], target: InPort[T]) -> None:
    differs = difference(source.type._descriptor_, target.type._descriptor_)
    if differs is not None:
        raise PortTypeError(f"{source} and {target} have different types\n{differs}")


def _check_limits(connector: DataConnector[T]) -> None:
    settings, source, target = connector.settings, connector.source, connector.target
    fewest = min(source.connectors, target.connectors, key=len)
    existing = [c for c in fewest if c.source is source and c.target is target]
    if existing and not settings.allow_duplicate:
        raise DuplicateConnectionError(
            f"{source} and {target} are connected already, by {existing[0].name!r}"
        )
    for key, limit, port in (
        ("dataport.fan_out", settings.fan_out, source),
        ("dataport.fan_in", settings.fan_in, target),
    ):
        if limit is not None and len(port.connectors) >= limit:
            raise ConnectionLimitError(
                f"{port} has {len(port.connectors)} connections; {key} allows {limit}"
            )


def _snapshot_between(source: type[T], target: type[T]) -> Callable[[T], T]:
    """Return a function that copies a sample, also between packages with different classes."""
    if source is target:
        return source._snapshot_
    return lambda value: target.from_cdr(value.to_cdr())
