"""What a station on a bus sees of it: frames, the time, and timers. No I/O and no bus are here.

In real time a link is a python-can bus with a thread, in simulated time a bus on the system's
clock. All stations of one process on one channel share a link.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import Protocol

from rtgen.runtime.canopen.frames import Frame
from rtgen.runtime.canopen.sdo_channel import SdoChannel


class Station(Protocol):
    """A node, a proxy's view of one, a manager, a monitor: whatever takes frames from a bus.

    The link calls it with `Link.lock` held, and sends what it returns. It must neither block nor
    call the link's blocking operations.
    """

    @property
    def identifiers(self) -> frozenset[int] | None:
        """The CAN identifiers that it takes, None for all; `Link.refresh` tells of a change."""

    @property
    def deadline(self) -> int | None:
        """When `poll` is to be called, in ns of `Link.now`; None for never."""

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        """Takes a frame that another station sent."""

    def poll(self, now: int) -> Iterable[Frame]:
        """Does what is due."""

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        """The bus has gone (bus-off, hub dead), or is back."""


class NmtMaster(Protocol):
    """The NMT master of a bus: there is one at most for each link."""

    def request(self, command: int, node_id: int) -> None:
        """Sends an NMT command for a node (0: all), and notes that it was asked for."""

    def readiness(self, node_id: int) -> bool | str:
        """Whether the node is configured, so that it may be started; a text says why it cannot be.

        A node that the master does not know is ready.
        """


class Link(ABC):
    """A process's access to one bus. What calls stations' methods from outside holds `lock`."""

    master: NmtMaster | None
    """Who sends NMT commands; proxies ask it."""
    carries_remote_frames: bool = True
    """Whether remote frames go through: socketcand's protocol has none."""

    @property
    @abstractmethod
    def lock(self) -> AbstractContextManager[object]:
        """Held while stations are called; re-entrant."""

    @property
    @abstractmethod
    def up(self) -> bool:
        """Whether frames go through."""

    @abstractmethod
    def now(self) -> int:
        """The time that stations go by, in ns: it never jumps."""

    @abstractmethod
    def attach(self, station: Station) -> None:
        """Lets a station take frames from now on."""

    @abstractmethod
    def detach(self, station: Station) -> None:
        """Ends that; the last one closes the link."""

    @abstractmethod
    def refresh(self, station: Station) -> None:
        """The station's `identifiers` or `deadline` have changed, outside of a call by the link."""

    @abstractmethod
    def send(self, frames: Iterable[Frame], sender: Station | None = None) -> None:
        """Queues frames; other stations of the process get them, too, the sender does not.

        Raises LinkError if the bus is gone; what cannot be queued is counted as lost.
        """

    @abstractmethod
    def sdo(self, node_id: int) -> SdoChannel:
        """The process's SDO client of a node: transfers queue up there."""

    @abstractmethod
    def wait(self, until: Callable[[], bool], timeout: int) -> bool:
        """Waits till `until()` holds, at most `timeout` ns; whether it does.

        Not from a station's methods. In simulated time no time passes: the frames that wait are
        delivered, in the order of arbitration, until it holds or none is left.
        """


def no_guarding(link: Link) -> str:
    """Why node guarding is impossible on a link without remote frames."""
    return f"{link} carries no remote frames, so nodes cannot be guarded"
