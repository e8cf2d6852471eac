"""The ways to the processes that run a system: over DDS or Zenoh, or to a run of this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.local_link import LocalLink
from rtgen.runtime.distribution.local_runs import Hello, Wire
from rtgen.runtime.distribution.medium import PeerLostError
from rtgen.runtime.timing.clocks import SECOND
from rtgen.ui import description
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteRun, RemoteState

if TYPE_CHECKING:
    from rtgen.runtime.distribution.control import Asker
    from rtgen.runtime.distribution.medium import Subscription
    from rtgen.runtime.distribution.transport import DistributedTransport
    from rtgen.runtime.services.transports import RemotePort


class EngineLink:
    """See `peers_watcher.Link`; `connections` are those of the system's file."""

    time = None

    def __init__(
        self,
        transport: DistributedTransport,
        connections: Mapping[str, ui.Connection],
    ) -> None:
        self._peers = transport.peers
        self._peers.listeners.clear()
        self._state = RemoteState(connections=connections)
        self.asker = self._peers.asker
        self.listen = transport.listen
        self.give = transport.give
        self.close = transport.close

    @property
    def instances(self) -> Sequence[str]:
        """The components of all processes."""
        return self._peers.instances

    def look(self) -> RemoteState:
        """Return the connections of the file."""
        return self._state


class RunLink:
    """See `peers_watcher.Link`; follows a run of this machine, and those after it.

    When a run is over, the next one of the same system is joined. Raises OSError.
    """

    def __init__(self, path: Path, told: Callable[[], None] = lambda: None) -> None:
        self._told = told
        self._number = 1
        self._link = LocalLink(path, told)

    @property
    def hello(self) -> Hello:
        """What the run says of itself."""
        return self._link.hello

    @property
    def instances(self) -> Sequence[str]:
        """The components of the run; none when it is over."""
        return () if self._link.end else self._link.instances

    @property
    def time(self) -> float:
        """The time of the run [s]."""
        return self._link.time / SECOND

    def look(self) -> RemoteState:
        """Return the connections and the run; another one, if this one is over."""
        if self._link.end:
            self._join_next()
        link = self._link
        return RemoteState(
            connections={each.name: _connection(each) for each in link.wires},
            flows=[
                description.flow(each.name, each.losses, each.rate)
                for each in link.wires
            ],
            run=RemoteRun(self._number, link.hello.name, self._ended()),
        )

    def _ended(self) -> str:
        end, hello = self._link.end, self._link.hello
        return end and f"{end}. This page goes on when it runs again: {hello.command}"

    def _join_next(self) -> None:
        ended = self._link.hello
        try:
            following = (
                path
                for path, hello in local_runs.runs()
                if (hello.name, hello.file) == (ended.name, ended.file)
                and hello.time > ended.time
            )
            path = next(following, None)
            if path is not None:
                former, self._link = self._link, LocalLink(path, self._told)
                former.close()
                self._number += 1
        except OSError:
            return  # It is looked for again.

    def asker(self, instance: str) -> Asker:
        """See `LocalLink`."""
        return self._link.asker(instance)

    def listen(
        self, there: RemotePort, type_: type[Any], take: Callable[[Any], None]
    ) -> Subscription:
        """See `LocalLink`."""
        return self._link.listen(there, type_, take)

    def give(self, there: RemotePort, type_: type[Any], value: Any) -> None:
        """See `LocalLink`."""
        if self._link.end:
            raise PeerLostError(self._link.end)
        self._link.give(there, type_, value)

    def close(self) -> None:
        """Leave the run as it is."""
        self._link.close()


def chosen(runs: Sequence[tuple[Path, Hello]], wanted: str) -> list[tuple[Path, Hello]]:
    """Return the runs of a name or a process; without one, all."""
    return [
        (path, hello)
        for path, hello in runs
        if not wanted or wanted in (hello.name, str(hello.pid))
    ]


def _connection(wire: Wire) -> ui.Connection:
    return ui.Connection(
        name=wire.name,
        source=ui.PortAddress(*wire.source),
        target=ui.PortAddress(*wire.target),
        properties=[ui.Value(*pair) for pair in wire.properties.items()],
    )
