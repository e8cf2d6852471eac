"""Records a running system: samples, states, parameters, connections, CAN frames, board calls."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, Final, Protocol

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.descriptors import Descriptor
from rtgen.runtime.marshalling.layouts.formats import Format, UnsupportedError
from rtgen.runtime.marshalling.layouts.trees import parts, tree_of
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.return_codes import INACTIVE_STATE
from rtgen.runtime.system.json_printers import json_printer
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
from rtgen.runtime.xcdr import Representation, representation_of
from rtgen.tools.kit.member_units import units_of
from rtgen.tools.recording import messages
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.messages import Topic
from rtgen.tools.recording.schemas import Schema, schema_of

LAYOUT: Final = "1"
"""Version of the layout of channels and metadata."""

_SCOPED = re.compile(r"[A-Za-z_]\w*(::[A-Za-z_]\w*)*", re.ASCII)

Encoder = Callable[[Any], bytes]


class Writer(Protocol):
    """Destination of a recording: an MCAP file, or the clients of a live view."""

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Held while a message is put."""

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Write metadata of the whole recording."""

    def schema(self, name: str, encoding: str, text: str) -> int:
        """Announce a schema; return its id."""

    def channel(
        self, topic: str, encoding: str, schema: int, entries: Mapping[str, str]
    ) -> int:
        """Announce a channel of messages in an encoding; return its id."""

    def message(self, channel: int, time: int, data: bytes) -> None:
        """Write a message with a time [ns]."""

    def put(self, channel: int, time: int, data: bytes) -> None:
        """Write a message, for a caller that holds the lock."""


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
        self._encodings: dict[Any, tuple[int, str, Encoder]] = {}
        self._schemas: dict[Schema, int] = {}
        self._channels: dict[tuple[str, ...], int] = {}
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
        schema, encoding, encode = self._encoding(port.type)
        address = port.owner, port.name
        units = self._units(port)
        start, put, lock = self._start, self._writer.put, self._writer.lock
        channels: dict[str, int] = {}

        def channel_of(during: str) -> int:
            key = (*address, during)
            if key not in self._channels:
                entries = {
                    "kind": "sample",
                    "instance": port.owner,
                    "port": port.name,
                    "type": port.type._descriptor_.repository_id,
                    "during": during,
                    **units,
                }
                self._channels[key] = self._writer.channel(
                    topic_of(*address), encoding, schema, entries
                )
            channels[during] = self._channels[key]
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

    def _put(self, topic: str, kind: str, value: Any, **entries: str) -> None:
        with self._writer.lock:
            schema, encoding, encode = self._encoding(type(value))
            channel = self._channels.get((topic,))
            if channel is None:
                channel = self._writer.channel(
                    topic, encoding, schema, {"kind": kind, **entries}
                )
                self._channels[topic,] = channel
            self._writer.message(channel, self.now, encode(value))

    def _encoding(self, type_: Any) -> tuple[int, str, Encoder]:
        """Return schema, message encoding and encoder of a type."""
        encoding = self._encodings.get(type_)
        if encoding is None:
            encode = cdr_encoder(type_)
            if encode is None:
                encoding = 0, "json", _json_encoder(type_)
            else:
                encoding = self._schema(schema_of(type_._descriptor_)), "cdr", encode
            self._encodings[type_] = encoding
        return encoding

    def _schema(self, schema: Schema) -> int:
        if schema not in self._schemas:
            number = self._writer.schema(schema.name, schema.encoding, schema.text)
            self._schemas[schema] = number
        return self._schemas[schema]

    def _units(self, port: OutPort[Any]) -> dict[str, str]:
        """Return the entries of a port's unit, and of those of its members."""
        profile = self._system.component(port.owner).profile
        members = {
            ".".join(path): unit for path, unit in units_of(profile, port).units.items()
        }
        stated = (p.unit for p in profile.ports if p.name == port.name and not p.port)
        entries = {"unit": next(stated, "")}
        if members:
            entries["units"] = json.dumps(members, ensure_ascii=False)
        return {name: text for name, text in entries.items() if text}


def start_of(system: System) -> int:
    """Return the time of the clock at the start of a system [ns]."""
    return system.clock.now() - system.clock.elapsed()


def clock_of(system: System) -> dict[str, str]:
    """Return the metadata of a recording that describe its times."""
    is_simulated = isinstance(system.clock, SimulatedClock)
    clock = "simulated" if is_simulated else "real"
    return {"clock": clock, "start": str(start_of(system))}


def topic_of(instance: str, port: str) -> str:
    """Return the topic of a port."""
    return f"/{instance}/{port}"


def cdr_encoder(type_: Any) -> Encoder | None:
    """Return an encoder of payloads with encapsulation header; None if XCDR cannot encode the type.

    Version 1 of XCDR, or version 2 if the type requires it (DDS-XTypes 1.3, 7.6.3.1).
    """
    descriptor: Descriptor = type_._descriptor_
    if not _SCOPED.fullmatch(str(getattr(descriptor, "name", ""))):
        return None
    version = 2 if getattr(descriptor, "representation", 0) == 2 else 1
    kind: Representation = representation_of(type_, version)
    header = bytes((0, kind, 0, 0))
    try:
        for part in parts(descriptor):
            tree_of(part, Format(version))
    except UnsupportedError:
        return None
    body = compiled("to_cdr", descriptor, Format(version))

    def encode(value: Any) -> bytes:
        octets: bytes = header + body(value, True)
        return octets

    return encode


def _json_encoder(type_: Any) -> Encoder:
    printed = json_printer(type_)
    return lambda value: printed(value).encode()
