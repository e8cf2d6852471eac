"""Recordings that pages look at without a system that runs: one, or two beside each other."""

from __future__ import annotations

import json
import threading
import uuid
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from rtgen.diagnostics import ToolError
from rtgen.recording import messages
from rtgen.recording.errors import RecordingError
from rtgen.recording.events import Decoders, Log
from rtgen.recording.mcap_reader import Channel, McapFile, Message
from rtgen.recording.recorder import METADATA
from rtgen.recording.schema_types import type_of
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.return_codes import LifeCycleState
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import BusFrame
from rtgen.runtime.xcdr import deserialize
from rtgen.ui.buses import Describer, SeenBuses
from rtgen.ui.description import STATES
from rtgen.ui.errors import IMPOSSIBLE, CommandError
from rtgen.ui.history import History
from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind
from rtgen.ui.type_table import NO_TYPE, TypeTable

MOST_OCTETS: Final = 512 << 20
"""About what is kept of recordings; of longer ones the beginning is left out."""
_SET: Final = "recorded"
_TOPICS: Final = "topics"
"""The instance to which topics of other writers belong."""
_TYPES: Final = {
    "component": messages.Component,
    "parameter": messages.Parameter,
    "connection": messages.Connection,
    "state": messages.State,
    "frame": messages.CanFrame,
    "call": messages.BoardCall,
}


class AtOnce:
    """Carries out requests in the thread that brings them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def start(self) -> None:
        """Nothing runs."""

    def submit(self, request: Callable[[], None]) -> bool:
        """Carry out a request."""
        with self._lock:
            request()
        return True


class Recorded:
    """A recording, and perhaps another one beside it. Times count from the start of each run."""

    def __init__(
        self,
        files: Sequence[str],
        describer: Callable[[str], Describer],
        most_octets: int = MOST_OCTETS,
    ) -> None:
        """Raises ToolError if a file is no recording or cannot be decoded."""
        self.name = uuid.uuid4().hex
        self.runner = AtOnce()
        self.history = History(most_octets)
        self._types = TypeTable()
        self._numbers: dict[object, int] = {}
        self._known: list[Any] = []
        self._decoders = Decoders()
        self._now = 0.0
        self._buses = SeenBuses(describer, self._tell)
        self._components: dict[str, ui.Component] = {}
        self._changed: set[str] = set()
        self._channels: dict[Channel, ui.Channel] = {}
        self._all: list[ui.Channel] = []
        self._joined: list[messages.Connection] = []
        try:
            for beside, file in enumerate(files):
                self._read(file, beside=beside > 0)
        except RecordingError as error:
            raise ToolError(str(error), hint=error.hint) from error
        self._add_ports()
        self.left_out = self.history.first > 0.0
        clock = ui.ClockState(
            kind=ui.ClockKind.CLOCK_RECORDING, speed=1.0, ended=True, past=True
        )
        self.history.begin(
            ui.SystemState(
                name=Path(files[0]).name,
                components=[*self._components.values()],
                channels=self._all,
                time=clock,
                edits=ui.EditState(saved=True, file=files[0]),
                beside=Path(files[1]).name if len(files) > 1 else "",
            )
        )

    # Pages.

    def join(self, page: Outbox) -> None:
        """Greet a page and show it the end of the recording."""
        hello = ui.Hello(version=ui.VERSION, server=self.name, full=False)
        page.put(ui.Event.of_greeting(hello))
        self._look(page, self.history.last)

    def leave(self, page: Outbox) -> None:
        """Forget a page, of which nothing is known."""

    def close(self) -> None:
        """Nothing is open."""

    def carry_out(self, page: Outbox, message: ui.ClientMessage) -> None:
        """Carry out a command; its result goes to the page."""
        result = ui.Result(request=message.request, done=True)
        value: Any = message.asked.value
        try:
            match message.asked.discriminator:
                case CommandKind.COMMAND_WATCH:
                    added = frozenset(value) - page.watched
                    page.watched = frozenset(value)
                    past = self.history.last if page.past is None else page.past
                    page.show_more(self.history.samples(past, added))
                case CommandKind.COMMAND_LOOK:
                    self._look(page, self.history.last if value < 0 else value)
                case _:
                    raise CommandError(
                        IMPOSSIBLE,
                        "a recording can only be looked at",
                        "`rtgen ui SYSTEM` runs a system",
                    )
        except CommandError as error:
            result.done, result.code, result.hint = False, error.code, error.hint
            result.message = str(error)
        page.put(ui.Event.of_outcome(result))

    def _look(self, page: Outbox, time: float) -> None:
        now = self.history.nearest(time)
        page.show(self.history.at(now, self._types.nodes, page.watched), now)

    # Reading.

    def _tell(self, event: ui.Event) -> None:
        self.history.tell(self._now, event)

    def _read(self, file: str, *, beside: bool) -> None:
        log = Log(file)
        if log.mcap is None:
            raise RecordingError(
                f"{file} is a log in JSON lines",
                hint="pages show what `rtgen run --record FILE.mcap` writes",
            )
        start = _start(log, log.mcap)
        self._channels.clear()
        for message in log.mcap.messages():
            if start is None:
                start = message.time
            self._now = (message.time - start) / SECOND
            kind = message.channel.get("kind") or "sample"
            if kind == "run":
                break  # What follows belongs to the shutdown.
            if kind == "sample":
                self._sample(message, beside=beside)
            elif kind in _TYPES and (not beside or kind == "state"):
                self._event(message, _content(message, _TYPES[kind]), beside=beside)

    def _sample(self, message: Message, *, beside: bool) -> None:
        channel = self._channels.get(message.channel)
        if channel is None:
            channel = self._channel(message.channel, beside=beside)
        data = message.data
        if channel.type_number == NO_TYPE:
            data = json.dumps(self._decoders.value(message)).encode()
        self.history.sample(ui.Sample(channel=channel.id, time=self._now, data=data))

    def _channel(self, found: Channel, *, beside: bool) -> ui.Channel:
        """The channel of a port: a recording has one for each component that made it write."""
        address = ui.PortAddress(*_address_of(found))
        for known in self._channels.values():
            if known.port == address:
                self._channels[found] = known
                return known
        number = self._type_number(found)
        channel = ui.Channel(
            id=len(self._all) + 1, port=address, type_number=number, beside=beside
        )
        self._channels[found] = channel
        self._all.append(channel)
        if not beside:
            port = ui.Port(
                name=address.port,
                kind=ui.PortKind.PORT_OUT,
                type=found.schema.name,
                type_number=number,
                unit=found.get("unit"),
            )
            self._component(address.instance).ports.append(port)
        return channel

    def _type_number(self, channel: Channel) -> int:
        if channel.encoding != "cdr" or not channel.schema.encoding:
            return NO_TYPE
        if channel.schema not in self._numbers:
            type_ = type_of(channel.schema)
            self._known.append(type_)
            number = self._types.number(type_._descriptor_)
            self._numbers[channel.schema] = number
        return self._numbers[channel.schema]

    def _component(self, instance: str) -> ui.Component:
        if instance not in self._components:
            self._components[instance] = ui.Component(
                instance=instance,
                current=ui.State.STATE_INACTIVE,
                configuration_sets=[ui.ConfigurationSet(name=_SET)],
                active_set=_SET,
            )
        return self._components[instance]

    def _event(self, message: Message, content: Any, *, beside: bool) -> None:
        match content:
            case messages.Component(instance=instance, type=type_, rate=rate):
                component = self._component(instance)
                component.type = type_
                component.contexts = [ui.ExecutionContext(rate=rate, running=True)]
            case messages.Parameter(instance=instance, parameter=name, value=text):
                component = self._component(instance)
                if all(each.name != name for each in component.parameters):
                    component.parameters.append(ui.Parameter(name=name))
                change = ui.ParameterChange(instance, _SET, name, text, True)
                self._tell(ui.Event.of_setting(change))
            case messages.Connection(name=name, connected=True):
                self._joined.append(content)
                connection = ui.Connection(
                    name=name,
                    source=_address(content.source),
                    target=_address(content.target),
                    properties=[ui.Value(p.name, p.value) for p in content.properties],
                )
                self._tell(ui.Event.of_connected(connection))
            case messages.Connection(name=name):
                self._tell(ui.Event.of_cut(name))
            case messages.State(instance=instance):
                self._state(content, beside=beside)
            case messages.CanFrame(id=can_id, extended=extended, remote=remote):
                bus = message.channel.get("bus")
                frame = BusFrame(bus, can_id, content.data, remote, extended)
                self._buses.on_frame(frame, self._now)
            case messages.BoardCall(request=request, reply=reply, error=error):
                call = ui.BoardCall(
                    time=self._now,
                    instance=message.channel.get("instance"),
                    request=request,
                    reply=reply,
                    round_trip=-1.0,
                    error=error,
                )
                self._tell(ui.Event.of_call(call))

    def _state(self, content: messages.State, *, beside: bool) -> None:
        before, after = (_state_of(name) for name in (content.before, content.after))
        change = ui.StateChange(
            self._now, content.instance, content.context, before, after, content.reason
        )
        if beside:
            self._tell(ui.Event.of_other(change))
            return
        if content.instance not in self._changed:
            self._changed.add(content.instance)
            self._component(content.instance).current = before
        self._tell(ui.Event.of_change(change))

    def _add_ports(self) -> None:
        """Ports that are known by their connections only."""
        sources = {
            (component.instance, port.name): port
            for component in self._components.values()
            for port in component.ports
        }
        for connection in self._joined:
            ends = _address(connection.source), _address(connection.target)
            source = sources.get((ends[0].instance, ends[0].port))
            for end in ends:
                port = ui.Port(end.port, ui.PortKind.PORT_SERVICE, type_number=NO_TYPE)
                if source is not None:
                    port.kind, port.type = ui.PortKind.PORT_IN, source.type
                    port.type_number = source.type_number
                ports = self._component(end.instance).ports
                if all(each.name != end.port for each in ports):
                    ports.append(port)


def _start(log: Log, file: McapFile) -> int | None:
    """When the run has started [ns]; None in the files of other writers, which do not say it."""
    return log.start if METADATA in file.metadata else None


def _content(message: Message, type_: Any) -> Any:
    try:
        return deserialize(type_, message.data)
    except CdrError as error:
        raise RecordingError(f"{message.channel.topic}: {error}") from error


def _state_of(name: str) -> ui.State:
    try:
        return STATES[LifeCycleState[name]]
    except KeyError:
        raise RecordingError(f"{name!r} is not a state of a component") from None


def _address_of(channel: Channel) -> tuple[str, str]:
    return channel.get("instance") or _TOPICS, channel.get("port") or channel.topic


def _address(text: str) -> ui.PortAddress:
    instance, _, port = text.partition(".")
    return ui.PortAddress(instance, port)
