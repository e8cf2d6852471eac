"""The threads of a link to a hub: timers have their own only while the hub is away."""

from __future__ import annotations

import threading
from collections.abc import Iterable

import pytest
from hub_process import HubProcess
from patience import until
from stations import Recorder

from rtgen.runtime import RealClock
from rtgen.runtime.canopen.bus.link import Link
from rtgen.runtime.canopen.bus.links import open_link
from rtgen.runtime.canopen.wire.frames import Frame

pytestmark = pytest.mark.waits

PERIOD = 5_000_000
HOUR = 3600 * 1_000_000_000


class Polled(Recorder):
    """Records the threads that call its timers and bring its frames."""

    def __init__(self, link: Link) -> None:
        super().__init__()
        self.link = link
        self.pollers: list[str] = []
        self.bringers: list[str] = []

    def poll(self, now: int) -> Iterable[Frame]:
        self.pollers.append(_name())
        return super().poll(now)

    def receive(self, frame: Frame, now: int) -> Iterable[Frame]:
        self.bringers.append(_name())
        return super().receive(frame, now)

    def link_changed(self, up: bool, now: int) -> Iterable[Frame]:
        self.pollers.clear()
        return super().link_changed(up, now)

    def set(self, period: int, deadline: int) -> None:
        """Set the timer, from the thread of the test."""
        with self.link.lock:
            self.period, self.deadline = period, self.link.now() + deadline
            self.link.refresh(self)
            self.pollers.clear()


def _name() -> str:
    return threading.current_thread().name.rpartition(" ")[2]


def _own() -> set[str]:
    """The threads of links."""
    names = [each.name for each in threading.enumerate()]
    return {n.rpartition(" ")[2] for n in names if n.startswith("rtgen socketcand")}


def connected(hub: HubProcess) -> Link:
    options = f"host={hub.host},port={hub.port}"
    return open_link(RealClock(), "socketcand", "can0", 0, options)


def test_timers_are_called_by_the_thread_that_receives() -> None:
    with HubProcess() as hub:
        link = connected(hub)
        station = Polled(link)
        station.deadline = link.now() + HOUR
        link.attach(station)
        assert _own() == {"receive", "transmit"}
        station.set(PERIOD, 0)
        until(lambda: len(station.pollers) >= 6)
        assert {*station.pollers} == {"receive"}
        station.set(0, HOUR)
        assert not station.pollers
        station.set(0, PERIOD)  # earlier than the time until which the thread waits
        until(lambda: station.pollers == ["receive"])
        link.detach(station)
    assert not _own()


def test_timers_go_on_while_the_hub_is_away() -> None:
    with HubProcess() as hub:
        link = connected(hub)
        station = Polled(link)
        link.attach(station)
        station.set(PERIOD, 0)
    until(lambda: station.changes == [False])
    until(lambda: len(station.pollers) >= 6)
    assert {*station.pollers} == {"timers"}
    with HubProcess(port=hub.port):
        until(lambda: station.changes == [False, True])
        until(lambda: _own() == {"receive", "transmit"})
        station.set(PERIOD, 0)
        until(lambda: len(station.pollers) >= 6)
        assert {*station.pollers} == {"receive"}
        link.detach(station)
    assert not _own()


def test_a_link_closes_while_the_hub_is_away() -> None:
    with HubProcess() as hub:
        link = connected(hub)
        station = Polled(link)
        link.attach(station)
        station.set(PERIOD, 0)
    until(lambda: len(station.changes) == 1)
    link.detach(station)
    assert not _own()
