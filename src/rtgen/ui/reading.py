"""Reads recordings into a history: samples, and events of components and buses for pages."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any, Final

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.descriptors import Descriptor
from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.return_codes import LifeCycleState
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import BoardCall, BusFrame
from rtgen.tools.recording import messages
from rtgen.tools.recording.bag_files import Recording
from rtgen.tools.recording.errors import RecordingError
from rtgen.tools.recording.events import Decoders, Log, units_by_path
from rtgen.tools.recording.mcap_reader import Channel, Message
from rtgen.tools.recording.mcap_writer import METADATA
from rtgen.tools.recording.schema_types import decoder, type_of
from rtgen.ui import boards
from rtgen.ui.buses import DescriberOf, SeenBuses
from rtgen.ui.description import STATES
from rtgen.ui.history import History
from rtgen.ui.protocol import ui
from rtgen.ui.type_table import NO_TYPE, TypeTable

MAX_OCTETS: Final = 512 << 20
"""Approximate size kept of recordings; the beginning of longer ones is omitted."""
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


class Reading:
    """Recordings that are read into `history`. Times count from the start of each run.

    Types are entered in `types`; channels have the next of `numbers`. `codec` returns the codec of
    a marshaller type.
    """

    def __init__(
        self,
        history: History,
        types: TypeTable,
        numbers: Iterator[int],
        describer: DescriberOf,
        codec: Callable[[str], Codec | None],
    ) -> None:
        self.history = history
        self.components: dict[str, ui.Component] = {}
        """Those of the runs that are not shown beside another one."""
        self.channels: list[ui.Channel] = []
        self.descriptors: dict[int, Descriptor] = {}
        """Those of the types of samples, by the numbers of channels."""
        self._types = types
        self._channel_numbers = numbers
        self._numbers: dict[object, int] = {}
        self._known: dict[object, Any] = {}
        self._decoders = Decoders()
        self._now = 0.0
        self._settings: dict[str, dict[str, str]] = {}
        self._buses = SeenBuses(describer, self._settings.values, self._add)
        self._codec_of = codec
        self._codecs = boards.Codecs(self._codec)
        self._changed: set[str] = set()
        self._of_messages: dict[Channel, ui.Channel] = {}
        self._joined: list[messages.Connection] = []

    def _add(self, event: ui.Event) -> None:
        self.history.add(self._now, event)

    def read(self, file: str, *, beside: bool) -> None:
        """Read a recording; with `beside`, only samples and states.

        Raises RecordingError.
        """
        log = Log(file)
        if log.recording is None:
            raise RecordingError(
                f"{file} is a log in JSON lines",
                hint="pages show what `rtgen run --record FILE.mcap` writes",
            )
        start = _start(log, log.recording)
        self._of_messages.clear()
        for message in log.recording.messages():
            if start is None:
                start = message.time
            self._now = (message.time - start) / SECOND
            kind = message.channel.get("kind") or "sample"
            if kind == "run":
                break  # what follows belongs to the shutdown
            if kind == "sample":
                self._sample(message, beside=beside)
            elif kind in _TYPES and (not beside or kind == "state"):
                self._event(message, _content(message, _TYPES[kind]), beside=beside)
        if not beside:
            self._add_ports()

    def _sample(self, message: Message, *, beside: bool) -> None:
        channel = self._of_messages.get(message.channel)
        if channel is None:
            channel = self._channel(message.channel, beside=beside)
        data = message.data
        if channel.type_number == NO_TYPE:
            data = _json(self._decoders.value(message))
        self.history.sample(ui.Sample(channel=channel.id, time=self._now, data=data))

    def _channel(self, shown: Channel, *, beside: bool) -> ui.Channel:
        """Return the channel of a port; a recording has one for each component that wrote."""
        address = ui.PortAddress(*_address_of(shown))
        for listed in self._of_messages.values():
            if listed.port == address:
                self._of_messages[shown] = listed
                return listed
        number = self._type_number(shown)
        channel = ui.Channel(
            id=next(self._channel_numbers),
            port=address,
            type_number=number,
            beside=beside,
        )
        self._of_messages[shown] = channel
        if number != NO_TYPE:
            self.descriptors[channel.id] = self._known[shown.schema]._descriptor_
        self.channels.append(channel)
        if not beside:
            port = ui.Port(
                name=address.port,
                kind=ui.PortKind.PORT_OUT,
                type=shown.schema.name,
                type_number=number,
                unit=shown.get("unit"),
                units=[ui.Value(*pair) for pair in units_by_path(shown).items()],
            )
            self._component(address.instance).ports.append(port)
        return channel

    def _type_number(self, channel: Channel) -> int:
        if channel.encoding != "cdr" or not channel.schema.encoding:
            return NO_TYPE
        if channel.schema not in self._numbers:
            type_ = type_of(channel.schema)
            self._known[channel.schema] = type_
            number = self._types.number(type_._descriptor_)
            self._numbers[channel.schema] = number
        return self._numbers[channel.schema]

    def _component(self, instance: str) -> ui.Component:
        if instance not in self.components:
            self.components[instance] = ui.Component(
                instance=instance,
                current=ui.State.STATE_INACTIVE,
                configuration_sets=[ui.ConfigurationSet(name=_SET)],
                active_set=_SET,
            )
        return self.components[instance]

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
                self._settings.setdefault(instance, {})[name] = text
                change = ui.ParameterChange(instance, _SET, name, text, True)
                self._add(ui.Event.of_setting(change))
            case messages.Connection(name=name, connected=True):
                self._joined.append(content)
                connection = ui.Connection(
                    name=name,
                    source=_address(content.source),
                    target=_address(content.target),
                    properties=[ui.Value(p.name, p.value) for p in content.properties],
                )
                self._add(ui.Event.of_connected(connection))
            case messages.Connection(name=name):
                self._add(ui.Event.of_cut(name))
            case messages.State(instance=instance):
                self._state(content, beside=beside)
            case messages.CanFrame(id=can_id, extended=extended, remote=remote):
                bus = message.channel.get("bus")
                frame = BusFrame(bus, can_id, content.data, remote, extended)
                self._buses.on_frame(frame, self._now)
            case messages.BoardCall(request=request, reply=reply, error=error):
                instance = message.channel.get("instance")
                made = BoardCall(instance, request, reply, error)
                joined = (
                    (_address(each.source).instance, _address(each.target).instance)
                    for each in self._joined
                )
                codec = self._codecs.of(instance, joined)
                call = boards.described_call(made, self._now, codec, -1.0)
                self._add(ui.Event.of_call(call))

    def _codec(self, instance: str) -> Codec | None:
        component = self.components.get(instance)
        return None if component is None else self._codec_of(component.type)

    def _state(self, content: messages.State, *, beside: bool) -> None:
        before, after = (_state_of(name) for name in (content.before, content.after))
        change = ui.StateChange(
            self._now, content.instance, content.context, before, after, content.reason
        )
        if beside:
            self._add(ui.Event.of_other(change))
            return
        if content.instance not in self._changed:
            self._changed.add(content.instance)
            self._component(content.instance).current = before
        self._add(ui.Event.of_change(change))

    def _add_ports(self) -> None:
        """Add ports that only occur in connections.

        An InPort and an OutPort of a component may have the same name.
        """
        by_port = {
            (component.instance, port.name): port
            for component in self.components.values()
            for port in component.ports
        }
        for connection in self._joined:
            source, target = _address(connection.source), _address(connection.target)
            port = by_port.get((source.instance, source.port), ui.Port())
            kinds = [ui.PortKind.PORT_SERVICE] * 2
            if port.name or any(
                p.name[:9] == "dataport." for p in connection.properties
            ):
                kinds = [ui.PortKind.PORT_OUT, ui.PortKind.PORT_IN]
            number = port.type_number if port.name else NO_TYPE
            for end, kind in zip((source, target), kinds, strict=True):
                ports = self._component(end.instance).ports
                if (end.port, kind) not in [(each.name, each.kind) for each in ports]:
                    ports.append(
                        ui.Port(end.port, kind, type=port.type, type_number=number)
                    )


def _start(log: Log, file: Recording) -> int | None:
    """Return the start time of the run [ns]; None if missing, as in files of other writers."""
    return log.start if METADATA in file.metadata else None


def _json(value: Any) -> bytes:
    """Return a value as JSON, with numbers that are not finite as texts."""
    try:
        return json.dumps(value, allow_nan=False).encode()
    except ValueError:
        finite = json.loads(json.dumps(value), parse_constant=str)
        return json.dumps(finite).encode()


def _content(message: Message, type_: Any) -> Any:
    try:
        return decoder(message.channel.schema)(type_, message.data)
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
