"""Requests of other programs of this machine, executed between two steps of a simulated run."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Final, Protocol

from rtgen.runtime.requests import Queues, Requests

_MAX_OF_CLIENT: Final = 64
_SHARE: Final = 0.2
"""The part of the time of a simulated run for requests."""
_BURST: Final = 0.5
"""Time that is saved up for them [s]."""
_LONGEST: Final = 0.01
"""Time for them at once [s]."""


class Doing(Protocol):
    """What programs can ask of the one that runs the system; methods are called from any thread."""

    def do(self, client: Hashable, what: str, octets: bytes) -> bytes:
        """Carry out a request of a client. Raises ValueError, or RtcError if it is refused."""

    def left(self, client: Hashable) -> None:
        """End what a client has begun: it has left."""


class InRun:
    """Executes requests in the thread of a run, between two of its steps; see `control.Work`."""

    def __init__(self) -> None:
        self._requests = Requests(_SHARE, _BURST)
        self._queues = Queues(self._requests, _MAX_OF_CLIENT, 1)

    def submit(
        self, work: Callable[[], None], client: Hashable, *, first: bool = False
    ) -> bool:
        """Execute work soon; return False if too much of the client waits."""
        return self._queues.put(client, work, first=first)

    def carry_out(self) -> None:
        """Execute what waits."""
        self._requests.carry_out(_LONGEST)
