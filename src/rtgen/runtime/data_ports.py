"""Data ports: what a component reads from and writes to.

A sample belongs to one side at a time: `write` takes a snapshot of it, so the writer may go on
using its object, and what `read` returns belongs to the reader.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rtgen.runtime.buffers import EmptyPolicy, RingBuffer
from rtgen.runtime.descriptors import DataType
from rtgen.runtime.errors import SampleTypeError
from rtgen.runtime.guards import SINGLE_THREAD, Guard
from rtgen.runtime.return_codes import PORT_OK, PortStatus

if TYPE_CHECKING:
    from rtgen.runtime.connectors import DataConnector

T = TypeVar("T", bound=DataType)

_NOTHING: deque[Any] = deque(maxlen=0)


class InPort(Generic[T]):
    """The receiving end of data connections. With several, the samples come in order of arrival."""

    __slots__ = (
        "_arrivals",
        "_connectors",
        "_feed",
        "_guard",
        "_last",
        "_sole",
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
        """Samples lost on connections that are cut."""
        self._arrivals: deque[RingBuffer[T]] | None = None
        self._feed: Callable[[], None] | None = None
        """Brings a sample into a buffer of this port, if one waits elsewhere."""
        # The samples of the only buffer, where one thread alone comes here: the short way.
        self._sole: deque[T] = _NOTHING
        self._unread: deque[Any] = _NOTHING

    def __repr__(self) -> str:
        return f"<InPort {self}: {self.type.__name__}>"

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"

    def is_new(self) -> bool:
        """Whether there is an unread sample. Of a pull connection too, unlike in OpenRTM."""
        if self._unread:
            return True
        if self._feed is not None:
            self._feed()
        return bool(self._unread)

    def read(self) -> T | None:
        """The oldest unread sample.

        With none unread the empty policy of the first connection decides: `readback` (also
        without connection) gives the very object of the last read again, None if there was none;
        `do_nothing` gives None; `block` waits for a sample in real time, then gives None. In
        simulated time nobody could bring one, so it gives None at once.
        """
        samples = self._sole
        if samples:
            self._last = value = samples.popleft()
            return value
        return self._read_guarded()

    def read_newest(self) -> T | None:
        """The newest unread sample, None if there is none; older ones count as read."""
        samples = self._sole
        if samples:
            self._last = value = samples.pop()
            samples.clear()
            return value
        with self._guard:
            newest = None
            while (buffer := self._oldest()) is not None:
                self._last = newest = buffer.take()
            self._guard.notify_all()
        return newest

    @property
    def connectors(self) -> tuple[DataConnector[T], ...]:
        """The connections, oldest first."""
        return self._connectors

    @property
    def last(self) -> T | None:
        """The sample that was read last; None before the first."""
        return self._last

    @property
    def lost(self) -> int:
        """Samples lost on the way here: overwritten, refused, dropped, or unread when cut."""
        return self.lost_when_cut + sum(
            connector.lost for connector in self._connectors
        )

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
            self._rewire()

    def _detach(self, connector: DataConnector[T]) -> None:
        with self._guard:
            self._connectors = tuple(c for c in self._connectors if c is not connector)
            self.lost_when_cut += connector.lost
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
        for buffer in buffers:
            buffer.arrivals = self._arrivals
        alone = self._arrivals is None and self._guard is SINGLE_THREAD
        self._sole = buffers[0].samples if alone and buffers else _NOTHING
        for connector in self._connectors:
            connector.source._rewire()


class OutPort(Generic[T]):
    """The sending end of data connections."""

    __slots__ = (
        "_connectors",
        "_record",
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
        self._record: Callable[[T], None] | None = None
        self._ways: tuple[Callable[[T], PortStatus], ...] = ()
        self._write: Callable[[T], PortStatus] = self._write_to_nobody

    def __repr__(self) -> str:
        return f"<OutPort {self}: {self.type.__name__}>"

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"

    def write(self, value: T) -> PortStatus:
        """Sends a snapshot of the sample over every connection.

        PORT_OK if all took it, else the status of the first that did not: BUFFER_FULL
        (`do_nothing`), BUFFER_TIMEOUT (`block`; at once in simulated time), CONNECTION_LOST;
        PRECONDITION_NOT_MET without connection. Raises SampleTypeError for a foreign type.
        """
        return self._write(value)

    @property
    def connectors(self) -> tuple[DataConnector[T], ...]:
        """The connections, oldest first."""
        return self._connectors

    def _observe(self, record: Callable[[T], None] | None) -> None:
        self._record = record
        self._rewire()

    def _attach(self, connector: DataConnector[T]) -> None:
        self._connectors += (connector,)
        self._rewire()

    def _detach(self, connector: DataConnector[T]) -> None:
        self._connectors = tuple(c for c in self._connectors if c is not connector)
        self._rewire()

    def _rewire(self) -> None:
        self._ways = tuple(connector.short_way() for connector in self._connectors)
        write: Callable[[T], PortStatus]
        if not self._ways:
            write = self._write_to_nobody
        elif len(self._ways) == 1:
            write = self._ways[0]
        else:
            write = self._write_to_all
        self._write = write if self._record is None else self._write_and_record

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

    def _write_and_record(self, value: T) -> PortStatus:
        if self._record is not None:
            self._record(self._checked(value))
        return self._write_to_all(value)

    def _checked(self, value: T) -> T:
        if not isinstance(value, self.type):
            raise SampleTypeError(
                f"{self} sends {self.type.__name__}, not {type(value).__name__}"
            )
        return value
