"""Common part of real and simulated links: stations, timers, delivery of frames."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

from rtgen.runtime.canopen.bus.link import Link, NmtMaster, Station
from rtgen.runtime.canopen.bus.sdo_channel import SdoChannel
from rtgen.runtime.canopen.errors import LinkError
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.timing.traffic import BusFrame, Traffic


class AttachedStation:
    """A station attached to a link."""

    __slots__ = ("deadline", "identifiers", "left", "order", "station", "up", "wake")

    def __init__(self, station: Station, order: int) -> None:
        self.station = station
        self.order = order
        self.identifiers: frozenset[int] | None = frozenset()
        self.deadline: int | None = None
        self.wake: int | None = None
        """Time of its timer, not later than its deadline."""
        self.up = True
        """Whether the station considers the bus available."""
        self.left = False

    def __lt__(self, other: AttachedStation) -> bool:
        return self.order < other.order


class AttachedStations:
    """The stations of a link, indexed by identifiers and by deadlines."""

    def __init__(self) -> None:
        self._attached: dict[int, AttachedStation] = {}
        self._receivers: dict[int, tuple[AttachedStation, ...]] = {}
        self._timers: list[tuple[int, AttachedStation]] = []
        self._added = 0

    def __len__(self) -> int:
        return len(self._attached)

    def __iter__(self) -> Iterator[AttachedStation]:
        return iter(tuple(self._attached.values()))

    def find(self, station: Station) -> AttachedStation | None:
        """Find a station."""
        return self._attached.get(id(station))

    def add(self, station: Station) -> AttachedStation:
        """Add a station after all others. Raises ValueError if it is already attached."""
        if id(station) in self._attached:
            raise ValueError(f"{station!r} is attached already")
        self._added += 1
        attached = self._attached[id(station)] = AttachedStation(station, self._added)
        self.update(attached)
        return attached

    def remove(self, attached: AttachedStation) -> None:
        """Remove a station."""
        del self._attached[id(attached.station)]
        attached.left = True
        attached.wake = None
        self._receivers.clear()

    def update(self, attached: AttachedStation, not_before: int = 0) -> None:
        """Update the index of a station; must be called after each call to the station."""
        station = attached.station
        identifiers = station.identifiers
        if identifiers is not attached.identifiers:
            if identifiers != attached.identifiers:
                self._receivers.clear()
            attached.identifiers = identifiers
        deadline = attached.deadline = station.deadline
        if deadline is not None:
            wake = deadline if deadline > not_before else not_before
            if attached.wake is None or wake < attached.wake:
                attached.wake = wake
                heappush(self._timers, (wake, attached))

    def receivers(self, can_id: int) -> tuple[AttachedStation, ...]:
        """Return the stations that receive an identifier, in order of attachment."""
        receivers = self._receivers.get(can_id)
        if receivers is None:
            if len(self._receivers) >= _CACHED_IDENTIFIERS:
                self._receivers.clear()
            receivers = self._receivers[can_id] = tuple(
                attached
                for attached in self._attached.values()
                if attached.identifiers is None or can_id in attached.identifiers
            )
        return receivers

    @property
    def deadline(self) -> int | None:
        """When the next station is due, None for never."""
        self._tidy()
        return self._timers[0][0] if self._timers else None

    def due(self, now: int) -> Iterator[AttachedStation]:
        """Yield the stations whose deadline has passed, each once, earliest first."""
        found = []
        while self._timers and self._timers[0][0] <= now:
            wake, attached = heappop(self._timers)
            if wake != attached.wake or attached.left:
                continue
            attached.wake = None
            if attached.deadline is not None and attached.deadline > now:
                attached.wake = attached.deadline
                heappush(self._timers, (attached.deadline, attached))
            elif attached.deadline is not None:
                found.append(attached)
        yield from found

    def _tidy(self) -> None:
        timers = self._timers
        while timers and (timers[0][1].left or timers[0][0] != timers[0][1].wake):
            heappop(timers)


_CACHED_IDENTIFIERS = 4096
"""Size of the cache of receivers by identifier, since there are many 29-bit identifiers."""


class SharedLink(Link):
    """A link with several stations.

    `lost` counts frames that were not sent, `bus` names the bus in messages.
    """

    def __init__(self, bus: str) -> None:
        self.bus = bus
        self.lost = 0
        self.master: NmtMaster | None = None
        self._attached = AttachedStations()
        self._sdo: dict[int, SdoChannel] = {}
        self._recorders: dict[Traffic, str] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.bus}>"

    def __str__(self) -> str:
        return self.bus

    @property
    def has_stations(self) -> bool:
        """Whether any station is attached."""
        return len(self._attached) > 0

    def attach(self, station: Station) -> None:
        """See `Link`. Raises ValueError if the station is already attached."""
        with self.lock:
            self._attached.add(station).up = self.up
            self._timers_changed()

    def detach(self, station: Station) -> None:
        """See `Link`. Ignores a station that is not attached."""
        with self.lock:
            attached = self._attached.find(station)
            if attached is None:
                return
            self._attached.remove(attached)
            if len(self._attached) > len(self._sdo):
                return
            for channel in self._sdo.values():
                # Pending transfers fail.
                channel.link_changed(False, self.now())
            for rest in self._attached:
                self._attached.remove(rest)
            self._sdo.clear()
            self.master = None
        self._close()

    def refresh(self, station: Station) -> None:
        """See `Link`."""
        with self.lock:
            attached = self._attached.find(station)
            if attached is not None:
                self._attached.update(attached)
                self._timers_changed()

    def send(self, frames: Iterable[Frame], sender: Station | None = None) -> None:
        """See `Link`."""
        with self.lock:
            attached = None if sender is None else self._attached.find(sender)
            if not self.up or (attached is not None and not attached.up):
                raise LinkError(f"{self.bus} is off")
            self._put(frames, attached)

    def sdo(self, node_id: int) -> SdoChannel:
        """See `Link`."""
        with self.lock:
            channel = self._sdo.get(node_id)
            if channel is None:
                channel = self._sdo[node_id] = SdoChannel(self, node_id)
                self._attached.add(channel).up = self.up
            return channel

    def report_to(self, traffic: Traffic, channel: str) -> None:
        """Report each frame on the bus to the watchers of a system, by the channel's name."""
        if traffic not in self._recorders:
            self._recorders = {**self._recorders, traffic: channel}

    # Implemented by the links

    @abstractmethod
    def _put(self, frames: Iterable[Frame], attached: AttachedStation | None) -> None:
        """Queue a station's frames; frames that cannot be queued count as lost."""

    @abstractmethod
    def _timers_changed(self) -> None:
        """Called when a deadline may precede the time waited for."""

    @abstractmethod
    def _close(self) -> None:
        """Called without the lock after the last station has been detached."""

    def _give(self, frame: Frame, sender: AttachedStation | None, now: int) -> None:
        """Deliver a frame to all stations except the sender."""
        for traffic, channel in self._recorders.items():
            if traffic.watchers:
                traffic.report(
                    BusFrame(
                        channel, frame.can_id, frame.data, frame.remote, frame.extended
                    )
                )
        for attached in self._attached.receivers(frame.can_id):
            if attached is not sender and attached.up and not attached.left:
                try:
                    frames = tuple(attached.station.receive(frame, now))
                except Exception as error:
                    self._failed(attached, error)
                    continue
                self._sent_by(attached, frames)

    def _poll(self, now: int) -> None:
        """Poll the stations that are due."""
        for attached in self._attached.due(now):
            if not attached.left:
                try:
                    frames = tuple(attached.station.poll(now))
                except Exception as error:
                    self._failed(attached, error)
                    frames = ()
                # Prevents an endless loop with a station that remains due.
                self._sent_by(attached, frames, now + MILLISECOND)

    def _turn(self, attached: AttachedStation, up: bool, now: int) -> None:
        """Notify a station that the bus is lost or available again."""
        if attached.up == up:
            return
        attached.up = up
        try:
            frames = tuple(attached.station.link_changed(up, now))
        except Exception as error:
            self._failed(attached, error)
            return
        self._sent_by(attached, frames)

    def _sent_by(
        self, attached: AttachedStation, frames: tuple[Frame, ...], not_before: int = 0
    ) -> None:
        self._attached.update(attached, not_before)
        if frames:
            self._put(frames, attached)

    def _failed(self, attached: AttachedStation, error: Exception) -> None:
        """Handle an exception of a station, which is a bug in the station."""
        raise error
