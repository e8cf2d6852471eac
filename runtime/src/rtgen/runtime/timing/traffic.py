"""Events of a system other than samples and states, for recorders.

Each clock has one `Traffic`: components, links and configuration sets know their clock. Without
watchers, events are not reported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeAlias


class ParameterChange(NamedTuple):
    """A parameter that has taken effect with a value, as text."""

    instance: str
    parameter: str
    value: str


class ConnectionChange(NamedTuple):
    """Two ports, `INSTANCE.PORT`, that were connected or disconnected."""

    name: str
    source: str
    target: str
    properties: Mapping[str, str]
    connected: bool


class BusFrame(NamedTuple):
    """A CAN frame on a bus, by the name of its channel."""

    bus: str
    can_id: int
    data: bytes
    remote: bool
    extended: bool


class BoardCall(NamedTuple):
    """A call that a communication RTC has made to a board; `error` is empty after success.

    `duration` is the time from the request to the end of the reply [ns], by the machine's clock
    even in simulated time.
    """

    instance: str
    request: bytes
    reply: bytes
    error: str
    duration: int = 0


class LogLine(NamedTuple):
    """A line of a component's log, with a level of `logging`, and the place of its code."""

    instance: str
    level: int
    text: str
    file: str
    function: str
    line: int


Event: TypeAlias = ParameterChange | ConnectionChange | BusFrame | BoardCall | LogLine
Watcher: TypeAlias = Callable[[Event], None]


class Traffic:
    """Watchers of a system's events. In real time they are called from any thread."""

    def __init__(self) -> None:
        self.watchers: tuple[Watcher, ...] = ()

    def watch(self, watcher: Watcher) -> None:
        """Add a watcher."""
        self.watchers = (*self.watchers, watcher)

    def unwatch(self, watcher: Watcher) -> None:
        """Remove a watcher; an unknown one is ignored."""
        self.watchers = tuple(each for each in self.watchers if each != watcher)

    def report(self, event: Event) -> None:
        """Notify the watchers of an event."""
        for watcher in self.watchers:
            watcher(event)
