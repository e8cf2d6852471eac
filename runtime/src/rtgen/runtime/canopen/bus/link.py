"""Interface between a bus and its stations: frames, time and timers. Without I/O.

In real time a link is a python-can bus with threads, in simulated time a bus on the system's clock.
All stations of a process on one channel share a link.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Protocol

from rtgen.runtime.canopen.bus.sdo_channel import SdoChannel
from rtgen.runtime.canopen.wire.frames import Frame


class Station(Protocol):
    """A participant of a bus: a node, a proxy's view of a node, a manager, a monitor.

    The link calls it with `Link.lock` held, and sends the frames that it returns. It must not
    block, nor call blocking operations of the link.
    """

    @property
    def identifiers(self) -> frozenset[int] | None:
        """The CAN identifiers to receive, None for all. Call `Link.refresh` after a change."""

    @property
    def deadline(self) -> int | None:
        """Time of the next call of `poll` [ns, as `Link.now`]; None for never."""

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """Process a frame sent by another station; return the frames to send."""

    def poll(self, now: int) -> Iterable[Frame]:
        """Process what is due; return the frames to send."""

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """Called when the bus is unavailable (bus-off, hub disconnected) or available again.

        Returns the frames to send.
        """


class NmtMaster(Protocol):
    """The NMT master of a bus; a link has at most one."""

    def request(self, command: int, node_id: int) -> None:
        """Send an NMT command to a node (0: all), and record the requested state."""

    def readiness(self, node_id: int) -> bool | str:
        """Return whether the node is configured, so that it can be started, or the reason if not.

        A node unknown to the master is ready.
        """


class Link(ABC):
    """A process's access to a bus. Outside callers of stations' methods must hold `lock`."""

    master: NmtMaster | None
    """The NMT master of the process, through which proxies send their commands."""
    carries_remote_frames: bool = True
    """Whether remote frames are transmitted: socketcand's protocol has none."""

    @property
    @abstractmethod
    def lock(self) -> AbstractContextManager[object]:
        """Re-entrant lock, held while stations are called."""

    @property
    @abstractmethod
    def up(self) -> bool:
        """Whether the bus is available."""

    @abstractmethod
    def now(self) -> int:
        """Return the monotonic time of the link's stations, in ns."""

    @abstractmethod
    def attach(self, station: Station) -> None:
        """Attach a station, which then receives frames."""

    @abstractmethod
    def detach(self, station: Station) -> None:
        """Detach a station; detaching the last one closes the link."""

    @abstractmethod
    def refresh(self, station: Station) -> None:
        """Announce a change of `identifiers` or `deadline` outside a call by the link."""

    @abstractmethod
    def send(self, frames: Iterable[Frame], sender: Station | None = None) -> None:
        """Queue frames; other stations of the process also receive them, except the sender."""

    @abstractmethod
    def sdo(self, node_id: int) -> SdoChannel:
        """Return the process's SDO client of a node, which queues transfers."""

    @abstractmethod
    def wait(self, until: Callable[[], bool], timeout: int) -> bool:
        """Wait until `until()` holds, at most `timeout` ns; return whether it holds.

        Must not be called by a station. In simulated time no time passes: queued frames are
        delivered in order of arbitration until `until()` holds or no frame is left.
        """


def no_guarding(link: Link) -> str:
    """Return why node guarding is impossible: the link has no remote frames."""
    return f"{link} carries no remote frames, so nodes cannot be guarded"
