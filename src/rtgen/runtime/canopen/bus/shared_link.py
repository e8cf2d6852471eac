"""Common part of real and simulated links: stations, timers, delivery of frames."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

from rtgen.runtime.canopen.bus.link import Link, NmtMaster, Station
from rtgen.runtime.canopen.bus.sdo_channel import SdoChannel
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame


class Seat:
    """A station attached to a link."""

    __slots__ = ("deadline", "identifiers", "left", "order", "station", "up", "wake")

    def __init__(self, station: Station, order: int) -> None:
        self.station = station
        self.order = order
        self.identifiers: frozenset[int] | None = frozenset()
        self.deadline: int | None = None
        self.wake: int | None = None
        """Its time in the queue of timers, not later than its deadline."""
        self.up = True
        """Whether the station regards the bus as available."""
        self.left = False

    def __lt__(self, other: Seat) -> bool:
        return self.order < other.order


class Seats:
    """The stations of a link, indexed by identifiers and by deadlines."""

    def __init__(self) -> None:
        self._seats: dict[int, Seat] = {}
        self._receivers: dict[int, tuple[Seat, ...]] = {}
        self._timers: list[tuple[int, Seat]] = []
        self._added = 0

    def __len__(self) -> int:
        return len(self._seats)

    def __iter__(self) -> Iterator[Seat]:
        return iter(tuple(self._seats.values()))

    def find(self, station: Station) -> Seat | None:
        """Find a station."""
        return self._seats.get(id(station))

    def add(self, station: Station) -> Seat:
        """Add a station after all others. Raises ValueError if it is already attached."""
        if id(station) in self._seats:
            raise ValueError(f"{station!r} is attached already")
        self._added += 1
        seat = self._seats[id(station)] = Seat(station, self._added)
        self.update(seat)
        return seat

    def remove(self, seat: Seat) -> None:
        """Remove a station."""
        del self._seats[id(seat.station)]
        seat.left = True
        seat.wake = None
        self._receivers.clear()

    def update(self, seat: Seat, not_before: int = 0) -> None:
        """Update the index of a station; must be called after each call to the station."""
        station = seat.station
        identifiers = station.identifiers
        if identifiers is not seat.identifiers:
            if identifiers != seat.identifiers:
                self._receivers.clear()
            seat.identifiers = identifiers
        deadline = seat.deadline = station.deadline
        if deadline is not None:
            wake = max(deadline, not_before)
            if seat.wake is None or wake < seat.wake:
                seat.wake = wake
                heappush(self._timers, (wake, seat))

    def receivers(self, can_id: int) -> tuple[Seat, ...]:
        """The stations that receive an identifier, in order of attachment."""
        receivers = self._receivers.get(can_id)
        if receivers is None:
            if len(self._receivers) >= _CACHED_IDENTIFIERS:
                self._receivers.clear()
            receivers = self._receivers[can_id] = tuple(
                seat
                for seat in self._seats.values()
                if seat.identifiers is None or can_id in seat.identifiers
            )
        return receivers

    @property
    def deadline(self) -> int | None:
        """When the next station is due, None for never."""
        self._tidy()
        return self._timers[0][0] if self._timers else None

    def due(self, now: int) -> Iterator[Seat]:
        """The stations whose deadline has passed, each once, earliest first."""
        found = []
        while self._timers and self._timers[0][0] <= now:
            wake, seat = heappop(self._timers)
            if wake != seat.wake or seat.left:
                continue
            seat.wake = None
            if seat.deadline is not None and seat.deadline > now:
                seat.wake = seat.deadline
                heappush(self._timers, (seat.deadline, seat))
            elif seat.deadline is not None:
                found.append(seat)
        yield from found

    def _tidy(self) -> None:
        timers = self._timers
        while timers and (timers[0][1].left or timers[0][0] != timers[0][1].wake):
            heappop(timers)


_CACHED_IDENTIFIERS = 4096
"""Size of the cache of receivers by identifier; 29-bit identifiers are many."""


class SharedLink(Link):
    """A link with several stations.

    `lost` counts frames that were not sent, `bus` names the bus in messages.
    """

    def __init__(self, bus: str) -> None:
        self.bus = bus
        self.lost = 0
        self.master: NmtMaster | None = None
        self._seats = Seats()
        self._sdo: dict[int, SdoChannel] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.bus}>"

    def __str__(self) -> str:
        return self.bus

    @property
    def has_stations(self) -> bool:
        """Whether any station is attached."""
        return len(self._seats) > 0

    def attach(self, station: Station) -> None:
        """See `Link`. Raises ValueError if the station is already attached."""
        with self.lock:
            self._seats.add(station).up = self.up
            self._timers_changed()

    def detach(self, station: Station) -> None:
        """See `Link`. Ignores a station that is not attached."""
        with self.lock:
            seat = self._seats.find(station)
            if seat is None:
                return
            self._seats.remove(seat)
            if len(self._seats) > len(self._sdo):
                return
            for channel in self._sdo.values():
                # Pending transfers fail.
                channel.link_changed(False, self.now())
            for rest in self._seats:
                self._seats.remove(rest)
            self._sdo.clear()
            self.master = None
        self._close()

    def refresh(self, station: Station) -> None:
        """See `Link`."""
        with self.lock:
            seat = self._seats.find(station)
            if seat is not None:
                self._seats.update(seat)
                self._timers_changed()

    def send(self, frames: Iterable[Frame], sender: Station | None = None) -> None:
        """See `Link`."""
        with self.lock:
            seat = None if sender is None else self._seats.find(sender)
            if not self.up or (seat is not None and not seat.up):
                raise LinkError(f"{self.bus} is off")
            self._put(frames, seat)

    def sdo(self, node_id: int) -> SdoChannel:
        """See `Link`."""
        with self.lock:
            channel = self._sdo.get(node_id)
            if channel is None:
                channel = self._sdo[node_id] = SdoChannel(self, node_id)
                self._seats.add(channel).up = self.up
            return channel

    # Implemented by the links

    @abstractmethod
    def _put(self, frames: Iterable[Frame], seat: Seat | None) -> None:
        """Queue a station's frames; frames that cannot be queued count as lost."""

    @abstractmethod
    def _timers_changed(self) -> None:
        """Called when a deadline may have become earlier than the one waited for."""

    @abstractmethod
    def _close(self) -> None:
        """Called without the lock when the last station has left."""

    def _give(self, frame: Frame, sender: Seat | None, now: int) -> None:
        """Deliver a frame to all stations except the sender."""
        for seat in self._seats.receivers(frame.can_id):
            if seat is not sender and seat.up and not seat.left:
                try:
                    frames = tuple(seat.station.receive(frame, now))
                except Exception as error:
                    self._failed(seat, error)
                    continue
                self._sent_by(seat, frames)

    def _poll(self, now: int) -> None:
        """Poll the stations that are due."""
        for seat in self._seats.due(now):
            if not seat.left:
                try:
                    frames = tuple(seat.station.poll(now))
                except Exception as error:
                    self._failed(seat, error)
                    frames = ()
                # Avoids an endless loop with a station that remains due.
                self._sent_by(seat, frames, now + MILLISECOND)

    def _turn(self, seat: Seat, up: bool, now: int) -> None:
        """Notify a station that the bus is lost or available again."""
        if seat.up == up:
            return
        seat.up = up
        try:
            frames = tuple(seat.station.link_changed(up, now))
        except Exception as error:
            self._failed(seat, error)
            return
        self._sent_by(seat, frames)

    def _sent_by(
        self, seat: Seat, frames: tuple[Frame, ...], not_before: int = 0
    ) -> None:
        self._seats.update(seat, not_before)
        if frames:
            self._put(frames, seat)

    def _failed(self, seat: Seat, error: Exception) -> None:
        """Called when a station has raised an exception, which is a bug in the station."""
        raise error
