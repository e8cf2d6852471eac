"""What real and simulated links have in common: stations, their timers, and who takes a frame."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.link import Link, NmtMaster, Station
from rtgen.runtime.canopen.sdo_channel import SdoChannel


class Seat:
    """A station's place at a link."""

    __slots__ = ("deadline", "identifiers", "left", "order", "station", "up", "wake")

    def __init__(self, station: Station, order: int) -> None:
        self.station = station
        self.order = order
        self.identifiers: frozenset[int] | None = frozenset()
        self.deadline: int | None = None
        self.wake: int | None = None
        """Where it stands in the queue of timers: not after its deadline."""
        self.up = True
        """Whether it is told that frames go through."""
        self.left = False

    def __lt__(self, other: Seat) -> bool:
        return self.order < other.order


class Seats:
    """The stations of a link, by the identifiers that they take and by their deadlines."""

    def __init__(self) -> None:
        self._seats: dict[int, Seat] = {}
        self._takers: dict[int, tuple[Seat, ...]] = {}
        self._timers: list[tuple[int, Seat]] = []
        self._added = 0

    def __len__(self) -> int:
        return len(self._seats)

    def __iter__(self) -> Iterator[Seat]:
        return iter(tuple(self._seats.values()))

    def find(self, station: Station) -> Seat | None:
        """The place of a station."""
        return self._seats.get(id(station))

    def add(self, station: Station) -> Seat:
        """Gives a station a place, behind all others. Raises ValueError if it has one."""
        if id(station) in self._seats:
            raise ValueError(f"{station!r} is attached already")
        self._added += 1
        seat = self._seats[id(station)] = Seat(station, self._added)
        self.look_at(seat)
        return seat

    def remove(self, seat: Seat) -> None:
        """Takes a place away."""
        del self._seats[id(seat.station)]
        seat.left = True
        seat.wake = None
        self._takers.clear()

    def look_at(self, seat: Seat, not_before: int = 0) -> None:
        """Notes what a station takes and when it is due; to be called after each call to it."""
        station = seat.station
        identifiers = station.identifiers
        if identifiers is not seat.identifiers:
            if identifiers != seat.identifiers:
                self._takers.clear()
            seat.identifiers = identifiers
        deadline = seat.deadline = station.deadline
        if deadline is not None:
            wake = max(deadline, not_before)
            if seat.wake is None or wake < seat.wake:
                seat.wake = wake
                heappush(self._timers, (wake, seat))

    def takers(self, can_id: int) -> tuple[Seat, ...]:
        """Who takes frames of an identifier, in the order of attachment."""
        takers = self._takers.get(can_id)
        if takers is None:
            if len(self._takers) >= _KNOWN_TAKERS:
                self._takers.clear()
            takers = self._takers[can_id] = tuple(
                seat
                for seat in self._seats.values()
                if seat.identifiers is None or can_id in seat.identifiers
            )
        return takers

    @property
    def deadline(self) -> int | None:
        """When a station is to be looked at, None for never."""
        self._tidy()
        return self._timers[0][0] if self._timers else None

    def due(self, now: int) -> Iterator[Seat]:
        """The stations whose deadline has come, each once, the earliest first."""
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


_KNOWN_TAKERS = 4096
"""Identifiers whose takers are kept; there are more of 29 bits."""


class SharedLink(Link):
    """A link of several stations.

    `lost` counts the frames that were not sent, `bus` names the bus in messages.
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
        """Whether anything is attached."""
        return len(self._seats) > 0

    def attach(self, station: Station) -> None:
        """See `Link`. Raises ValueError if it is attached already."""
        with self.lock:
            self._seats.add(station).up = self.up
            self._timers_changed()

    def detach(self, station: Station) -> None:
        """See `Link`. One that is not attached is no error."""
        with self.lock:
            seat = self._seats.find(station)
            if seat is None:
                return
            self._seats.remove(seat)
            if len(self._seats) > len(self._sdo):
                return
            for channel in self._sdo.values():
                # What waits for an answer is told that there will be none.
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
                self._seats.look_at(seat)
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

    # For the links.

    @abstractmethod
    def _put(self, frames: Iterable[Frame], seat: Seat | None) -> None:
        """Takes what a station sends; what does not go is counted as lost."""

    @abstractmethod
    def _timers_changed(self) -> None:
        """A deadline may be earlier than the one that is waited for."""

    @abstractmethod
    def _close(self) -> None:
        """The last station has left; called without lock."""

    def _give(self, frame: Frame, sender: Seat | None, now: int) -> None:
        """Lets all but the sender take a frame."""
        for seat in self._seats.takers(frame.can_id):
            if seat is not sender and seat.up and not seat.left:
                try:
                    frames = tuple(seat.station.receive(frame, now))
                except Exception as error:
                    self._failed(seat, error)
                    continue
                self._answered(seat, frames)

    def _poll(self, now: int) -> None:
        """Lets the stations do what is due."""
        for seat in self._seats.due(now):
            if not seat.left:
                try:
                    frames = tuple(seat.station.poll(now))
                except Exception as error:
                    self._failed(seat, error)
                    frames = ()
                # One that is still due is not asked again at once, for ever.
                self._answered(seat, frames, now + MILLISECOND)

    def _turn(self, seat: Seat, up: bool, now: int) -> None:
        """Tells a station that the bus has gone or is back."""
        if seat.up == up:
            return
        seat.up = up
        try:
            frames = tuple(seat.station.link_changed(up, now))
        except Exception as error:
            self._failed(seat, error)
            return
        self._answered(seat, frames)

    def _answered(
        self, seat: Seat, frames: tuple[Frame, ...], not_before: int = 0
    ) -> None:
        self._seats.look_at(seat, not_before)
        if frames:
            self._put(frames, seat)

    def _failed(self, seat: Seat, error: Exception) -> None:
        """A station raised what no station may."""
        raise error
