"""Replays a recording into a system: players replace the components that are not in it.

In simulated time a sample is written at the same time as in the recording, during the tick of the
component that wrote it. So the other components behave exactly as recorded, provided they depend on
nothing but their InPorts, their parameters and the time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

from rtgen.runtime import Component, ComponentProfile, InPort, OutPort, System
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.system.simulated_time import SimulatedScheduler
from rtgen.runtime.timing.clocks import SimulatedClock
from rtgen.runtime.xcdr import deserialize
from rtgen.tools.recording import messages
from rtgen.tools.recording.bag_files import Recording
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.mcap_reader import Channel
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.schemas import Schema, schema_of

_KINDS: dict[str, Any] = {
    "component": messages.Component,
    "connection": messages.Connection,
    "run": messages.Run,
}

Address = tuple[str, str]


@dataclass(slots=True)
class Course:
    """Facts of a recording that a replay needs in advance; times in ns since the start."""

    file: Recording
    start: int = 0
    components: list[messages.Component] = field(default_factory=list)
    connections: list[tuple[int, messages.Connection]] = field(default_factory=list)
    channels: dict[Address, Channel] = field(default_factory=dict)
    end: int = 0
    through: bool = True

    def beginning(self, present: Collection[str]) -> list[messages.Connection]:
        """Return the connections at the start of components that are `present`, in order."""
        return [
            connection
            for time, connection in self.connections
            if time == 0
            and connection.connected
            and (self._is_between(connection, present) or _inside(connection, present))
        ]

    def flow(self) -> Iterator[tuple[str, str]]:
        """Yield the instances of the ends of the data connections at the start."""
        for time, connection in self.connections:
            source, target = _ends(connection)
            is_data = source in self.channels or any(
                each.name.startswith("dataport.") for each in connection.properties
            )
            if time == 0 and connection.connected and is_data:
                yield source[0], target[0]

    def changes(
        self, present: Collection[str]
    ) -> Iterator[tuple[int, messages.Connection]]:
        """Yield the changes of data connections between components that are present and others."""
        for time, connection in self.connections:
            if self._is_between(connection, present):
                yield time, connection

    def _is_between(
        self, connection: messages.Connection, present: Collection[str]
    ) -> bool:
        source, target = _ends(connection)
        return source in self.channels and (source[0] in present) != (
            target[0] in present
        )


def is_run(file: Recording) -> bool:
    """Return whether `rtgen run --record` recorded a file with all events of a run."""
    return file.metadata.get(METADATA, {}).get("layout") == "1"


def course_of(file: Recording) -> Course:
    """Read through a recording of `rtgen run --record`. Raises RecordingError."""
    described = file.metadata.get(METADATA, {})
    if not is_run(file):
        raise RecordingError(
            f"{file.path} cannot be replayed: it is not a recording of rtgen run --record"
        )
    start = described.get("start", "")
    course = Course(file, int(start) if start.isascii() and start.isdecimal() else 0)
    for message in file.messages():
        time, kind = message.time - course.start, message.channel.get("kind")
        if kind == "sample":
            channel = message.channel
            course.channels[channel.get("instance"), channel.get("port")] = channel
        elif kind in _KINDS:
            try:
                value: Any = deserialize(_KINDS[kind], message.data)
            except CdrError as error:
                raise RecordingError(f"{file.path}: {kind}: {error}") from error
            if isinstance(value, messages.Component):
                course.components.append(value)
            elif isinstance(value, messages.Connection):
                course.connections.append((time, value))
            else:
                course.end, course.through = time, value.through
                break
        course.end = max(course.end, time)
    return course


class Player(Component):
    """Stands for a recorded component: writes its samples and reads nothing."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Player")


class Replay:
    """Replays a recording into a system in simulated time.

    First add the system's components and players for the others, in the recorded order; then
    `prepare` gives players their ports; then connect ports according to `Course.beginning`; then
    call `run`.
    """

    def __init__(self, course: Course, present: Collection[str]) -> None:
        self._course = course
        self._present = present
        self._ports: dict[Address, OutPort[Any]] = {}
        self._samples = self._of_ports()

    def prepare(self, system: System) -> None:
        """Give players their ports. Raises RecordingError if the type of a port has changed."""
        self._system = system
        self._players = {
            name
            for name in system.instances
            if isinstance(system.component(name), Player)
        }
        system.follow(self._course.flow())
        for time, connection in self._course.changes(self._present):
            source, target = _ends(connection)
            if source[0] in self._present:
                self._add_sink(source, target)
            else:
                self._add_source(source, target)
            at_start = time == 0 and connection.connected
            if not at_start and time < self._course.end:
                system.at(time, self._changing(connection))

    def properties(self, connection: messages.Connection) -> dict[str, str]:
        """Return the properties of a connection with a player, which reads every sample."""
        if _ends(connection)[0][0] in self._present:
            return {"dataport.allow_dup_connection": "YES"}
        return {each.name: each.value for each in connection.properties}

    def run(self, until: int | None = None) -> None:
        """Run to the end of the recording, or until an earlier time [ns]."""
        # During the run, whose beginning decides on the order of ticks.
        self._system.at(0, lambda: self._schedule(next(self._samples, None)))
        end = self._course.end
        if until is not None and until < end:
            self._system.run(until)
        elif not self._course.through:
            self._system.run(end)
        else:
            self._system.at(end, lambda: None)
            self._system.run(until=lambda system: system.time >= end)

    def _add_source(self, source: Address, target: Address) -> None:
        """Add an OutPort to the player, of the type of the port that it is connected to."""
        where = ".".join(target)
        component = self._system.component(target[0])
        if target[1] not in component.in_ports:
            raise RecordingError(f"{where}: there is no such InPort now")
        in_port: InPort[Any] = component.in_ports[target[1]]
        channel = self._course.channels[source]
        if channel.encoding != "cdr":
            raise RecordingError(
                f"{'.'.join(source)} is recorded as {channel.encoding}: it cannot be replayed"
            )
        _check(channel.schema, in_port)
        if source not in self._ports:
            player = self._system.component(source[0])
            self._ports[source] = player.add_out_port(source[1], in_port.type)

    def _add_sink(self, source: Address, target: Address) -> None:
        """Add an InPort to the player, so that the writer has a reader."""
        out_ports = self._system.component(source[0]).out_ports
        player = self._system.component(target[0])
        if source[1] not in out_ports:
            raise RecordingError(f"{'.'.join(source)}: there is no such OutPort now")
        if target[1] not in player.in_ports:
            player.add_in_port(target[1], out_ports[source[1]].type)

    def _changing(self, connection: messages.Connection) -> Callable[[], None]:
        def change() -> None:
            if connection.connected:
                properties = self.properties(connection)
                self._system.connect(*_ends(connection), properties, connection.name)
            else:
                self._system.disconnect(connection.name)

        return change

    # Samples

    def _of_ports(self) -> Iterator[_Sample]:
        """Yield the samples of the players' ports in recorded order."""
        for message in self._course.file.messages():
            channel = message.channel
            if channel.get("kind") == "sample":
                address = channel.get("instance"), channel.get("port")
                port = self._ports.get(address)
                if port is not None:
                    time = message.time - self._course.start
                    during = channel.get("during")
                    yield _Sample(time, during, port, message.data)

    def _schedule(self, sample: _Sample | None) -> None:
        """Schedule a sample, and the following ones at the same time."""
        if sample is None:
            return

        def write() -> None:
            following: _Sample | None = sample
            while following is not None and following.place == sample.place:
                following.write()
                following = next(self._samples, None)
            self._schedule(following)

        clock = self._system.clock
        assert isinstance(clock, SimulatedClock)
        assert isinstance(clock.instants, SimulatedScheduler)
        time, during = sample.place
        if during in self._players:
            context = self._system.context(during)
            clock.instants.in_turn_of(context, time, write)
        else:
            later = clock.instants.after_ticks
            self._system.at(time, lambda: later(write))


@dataclass(frozen=True, slots=True)
class _Sample:
    """A sample of a port at a time [ns], with the component that was ticking, if any."""

    time: int
    during: str
    port: OutPort[Any]
    data: bytes

    @property
    def place(self) -> tuple[int, str]:
        """The sort key of the time when it is due."""
        return self.time, self.during

    def write(self) -> None:
        """Write the sample to the port. Raises RecordingError."""
        try:
            value = deserialize(self.port.type, self.data)
        except CdrError as error:
            raise RecordingError(f"{self.port}: {error}") from error
        self.port.write(value)


def _address(text: str) -> Address:
    instance, _, port = text.partition(".")
    return instance, port


def _ends(connection: messages.Connection) -> tuple[Address, Address]:
    return _address(connection.source), _address(connection.target)


def _inside(connection: messages.Connection, present: Collection[str]) -> bool:
    return all(end[0] in present for end in _ends(connection))


def _check(recorded: Schema, port: InPort[Any]) -> None:
    """Raise RecordingError unless a port has the recorded type."""
    now = schema_of(port.type._descriptor_)
    if now != recorded:
        raise RecordingError(
            f"{port}: samples of {recorded.name} were recorded; its type is {now.name} now"
            + (", with another definition" if now.name == recorded.name else ""),
            hint="rtgen log cat shows the recorded samples",
        )
