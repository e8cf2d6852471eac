"""Records a running system: samples, states, parameters, connections, CAN frames, board calls."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import INACTIVE_STATE
from rtgen.runtime.system.observation import connection_change
from rtgen.runtime.system.records import MissingSamples, Record, StateRecord
from rtgen.runtime.system.system import System
from rtgen.runtime.timing.clocks import SimulatedClock
from rtgen.runtime.timing.traffic import (
    BoardCall,
    BusFrame,
    ConnectionChange,
    Event,
    LogLine,
    ParameterChange,
)
from rtgen.tools.kit.member_units import units_of
from rtgen.tools.recording import messages
from rtgen.tools.recording.channels import LAYOUT, Channels, Writer, unit_entries
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.messages import Topic


class Recorder:
    """A listener that records all events of a system, to an MCAP file or for a live view.

    Times are those of the clock: simulated from 0, real as UTC since 1970, in ns. Attach it before
    the first `run`, or to a run that is `under_way`: then it starts now, with the present states.
    """

    def __init__(
        self, system: System, writer: Writer, *, under_way: bool = False
    ) -> None:
        self.missing = MissingSamples()
        self._system = system
        self._writer = writer
        self._simulated = isinstance(system.clock, SimulatedClock)
        self._start = start_of(system)
        self._channels = Channels(writer)
        self._of_ports: dict[tuple[str, ...], int] = {}
        self._ticking = ""
        self._described: set[str] = set()
        self._unwrap: list[Callable[[], None]] = []
        entries = {"layout": LAYOUT, **clock_of(system)}
        if under_way:
            entries["start"] = str(self.now)
        writer.metadata(METADATA, entries)
        self._describe()
        if under_way:
            self._put_states()
        system.clock.traffic.watch(self._on_event)
        system.add_listener(self)

    def close(self) -> None:
        """Record nothing more."""
        self._system.clock.traffic.unwatch(self._on_event)
        self._system.remove_listener(self)
        for unwrap in self._unwrap:
            unwrap()

    def _put(self, topic: str, kind: str, value: Any, **entries: str) -> None:
        self._channels.put(topic, kind, value, lambda: self.now, **entries)

    @property
    def now(self) -> int:
        """The current time of the recording [ns]."""
        return self._start + self._system.time

    def end(self, *, through: bool) -> None:
        """Record the end of the run; later events belong to the shutdown.

        `through`: the actions due at the current time were executed.
        """
        self._put(Topic.RUN, "run", messages.Run("end", through))

    # Listener

    def __call__(self, record: Record) -> None:
        """Record a change of state."""
        if isinstance(record, StateRecord):
            if record.instance not in self._described:
                self._describe_component(record.instance)
                self._describe_parameters(record.instance)
            before, after = record.before.name, record.after.name
            state = messages.State(
                record.instance, before, after, record.ec_id, record.reason
            )
            self._put(Topic.STATES, "state", state)

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """See `SampleWriter`."""
        encode = self._channels.encoding(port.type).encode
        address = port.owner, port.name
        units = self._units(port)
        start, put, lock = self._start, self._writer.put, self._writer.lock
        channels: dict[str, int] = {}

        def channel_of(during: str) -> int:
            key = (*address, during)
            if key not in self._of_ports:
                self._of_ports[key] = self._channels.of_port(
                    *address, port.type, {"during": during, **units}
                )
            channels[during] = self._of_ports[key]
            return channels[during]

        channel_of(port.owner if self._simulated else "")

        def write(value: Any) -> None:
            try:
                data = encode(value)
            except CdrError as error:
                self.missing.add(port, error)
                return
            during = self._ticking
            with lock:
                channel = channels.get(during)
                if channel is None:
                    channel = channel_of(during)
                put(channel, start + elapsed(), data)

        return write

    # The rest

    def _describe(self) -> None:
        """Record the components, their parameters and connections at the start."""
        system = self._system
        for instance in system.instances:
            self._describe_component(instance)
        for instance in system.instances:
            self._describe_parameters(instance)
        for connector in system.connectors:
            self._put_connection(connection_change(connector, connected=True))

    def _put_states(self) -> None:
        for instance in self._system.instances:
            state = self._system.state(instance)
            if state is not INACTIVE_STATE:
                reason = self._system.component(instance).reason
                change = messages.State(
                    instance, INACTIVE_STATE.name, state.name, 0, reason
                )
                self._put(Topic.STATES, "state", change)

    def _describe_component(self, instance: str) -> None:
        self._described.add(instance)
        component = self._system.component(instance)
        context = self._system.context(instance)
        described = messages.Component(
            instance, component.profile.type_name, context.get_rate()
        )
        self._put(Topic.COMPONENTS, "component", described)
        if self._simulated:
            around = partial(self._around, instance)
            self._unwrap.append(context.put_around_ticks(around))

    def _describe_parameters(self, instance: str) -> None:
        sets = self._system.component(instance).configuration_sets
        for name, text in sets.texts(sets.active).items():
            self._put_parameter(ParameterChange(instance, name, text))

    def _around(self, instance: str, cycle: Callable[[], None]) -> Callable[[], None]:
        def tick() -> None:
            self._ticking = instance
            cycle()
            self._ticking = ""

        return tick

    def _on_event(self, event: Event) -> None:
        try:
            match event:
                case ParameterChange():
                    self._put_parameter(event)
                case ConnectionChange():
                    self._put_connection(event)
                case LogLine():
                    self._put(Topic.LOGS, "log", messages.LogLine(*event))
                case BusFrame(bus, can_id, data, remote, extended):
                    frame = messages.CanFrame(can_id, extended, remote, data)
                    self._put(Topic.CAN + bus, "frame", frame, bus=bus)
                case BoardCall(instance, request, reply, error):
                    call = messages.BoardCall(request, reply, error)
                    self._put(Topic.CALLS + instance, "call", call, instance=instance)
        except Exception as error:
            self._system.end_run(error)

    def _put_parameter(self, change: ParameterChange) -> None:
        self._put(Topic.PARAMETERS, "parameter", messages.Parameter(*change))

    def _put_connection(self, change: ConnectionChange) -> None:
        properties = [messages.Property(*each) for each in change.properties.items()]
        connection = messages.Connection(
            change.name, change.source, change.target, properties, change.connected
        )
        self._put(Topic.CONNECTIONS, "connection", connection)

    def _units(self, port: OutPort[Any]) -> dict[str, str]:
        """Return the entries of a port's unit, and of those of its members."""
        profile = self._system.component(port.owner).profile
        members = {
            ".".join(path): unit for path, unit in units_of(profile, port).units.items()
        }
        stated = (p.unit for p in profile.ports if p.name == port.name and not p.port)
        return unit_entries(next(stated, ""), members)


def start_of(system: System) -> int:
    """Return the time of the clock at the start of a system [ns]."""
    return system.clock.now() - system.clock.elapsed()


def clock_of(system: System) -> dict[str, str]:
    """Return the metadata of a recording that describe its times."""
    is_simulated = isinstance(system.clock, SimulatedClock)
    clock = "simulated" if is_simulated else "real"
    return {"clock": clock, "start": str(start_of(system))}
