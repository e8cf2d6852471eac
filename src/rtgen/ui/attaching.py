"""The ways to the processes that run a system: over DDS or Zenoh, or to a run of this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.local_link import LEFT_OUT, LocalLink
from rtgen.runtime.distribution.local_runs import Event, Hello, Wire
from rtgen.runtime.distribution.medium import MediumError, PeerLostError
from rtgen.runtime.failures import log
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.running.attached import (
    FRAME,
    READ,
    RECORD,
    STOP,
    WRITE,
    SendFrame,
    Transfer,
)
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.ui import description
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteRun, RemoteState

if TYPE_CHECKING:
    from rtgen.runtime.canopen.wire.frames import Frame
    from rtgen.runtime.distribution.control import Asker
    from rtgen.runtime.distribution.medium import Subscription
    from rtgen.runtime.distribution.transport import DistributedTransport
    from rtgen.runtime.services.transports import RemotePort
    from rtgen.ui.buses import Access


class EngineLink:
    """See `peers_watcher.Link`; `connections` are those of the system's file."""

    time = access = None

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

    def follow(self, take: object) -> None:
        """Do nothing: processes tell no events."""

    def state(self, instance: str) -> None:
        """Return None: states are asked for."""

    def look(self) -> RemoteState:
        """Return the connections of the file."""
        return self._state


class RunLink:
    """See `peers_watcher.Link`; follows a run of this machine, and those after it.

    When a run is over, the next one of the same system is joined. Each one is recorded, if there is
    a file for `recording`. Raises OSError, and MediumError if it cannot be recorded.
    """

    def __init__(
        self,
        path: Path,
        told: Callable[[], None] = lambda: None,
        recording: RecordingOptions | None = None,
    ) -> None:
        self._told = told
        self._recording = recording or RecordingOptions()
        self._take: Callable[[Event], None] = lambda event: None
        self._number = 1
        self._refused = ""
        """Why the next run cannot be joined."""
        self._link = self._joined(path)

    def _joined(self, path: Path) -> LocalLink:
        link = LocalLink(path, self._told, on_event=self._on_event)
        if self._recording.file is not None:
            options = self._recording.numbered(self._number)
            file = str(Path((self._recording.file and options.file) or "").absolute())
            octets = msgspec.msgpack.encode(replace(options, file=file))
            try:
                link.do(RECORD, octets)
            except MediumError:
                link.close()
                raise
        return link

    def _on_event(self, event: Event) -> None:
        self._take(event)

    def follow(self, take: Callable[[Event], None]) -> None:
        """See `Watcher`."""
        self._take = take

    def state(self, instance: str) -> tuple[str, str] | None:
        """Return the state of a component, and its reason, as told last; None if never."""
        return self._link.states.get(instance)

    @property
    def access(self) -> Access:
        """The access to the simulated buses of the run."""
        return self

    def send(self, bus: str, frame: Frame, period: float) -> None:
        """See `BusAccess`; raises MediumError only."""
        sent = SendFrame(
            bus, frame.can_id, frame.data, frame.remote, frame.extended, period
        )
        self._link.do(FRAME, msgspec.msgpack.encode(sent))

    def read(self, bus: str, node: int, number: tuple[int, int]) -> bytes:
        """See `BusAccess`; raises MediumError only."""
        return self._link.do(READ, msgspec.msgpack.encode(Transfer(bus, node, number)))

    def write(
        self, bus: str, node: int, number: tuple[int, int], octets: bytes
    ) -> None:
        """See `BusAccess`; raises MediumError only."""
        asked = Transfer(bus, node, number, octets)
        self._link.do(WRITE, msgspec.msgpack.encode(asked))

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
            chains=[*map(description.chain, link.chains)],
            run=RemoteRun(
                self._number,
                link.hello.name,
                self._ended(),
                link.hello.doc,
                tuple(map(description.planned, link.hello.plan)),
                LEFT_OUT if link.dropped else "",
            ),
        )

    def _ended(self) -> str:
        end, hello = self._link.end, self._link.hello
        if not end:
            return ""
        refused = self._refused and f" The next run cannot be shown: {self._refused}."
        again = f"This page goes on when it runs again: {hello.command}"
        return f"{end}.{refused} {again}"

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
        except OSError:
            return  # It is looked for again.
        if path is None:
            return
        self._number += 1
        try:
            former, self._link = self._link, self._joined(path)
        except (OSError, MediumError) as error:
            self._number -= 1
            self._refused = str(error)
            return
        former.close()
        self._refused = ""

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
        """Leave the run as it is, and end its recording."""
        if self._recording.file is not None and not self._link.end:
            try:
                self._link.do(STOP)
            except MediumError as error:
                log.warning("the recording may not be complete: %s", error)
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
