"""A session: one system that pages show and change, its pages, and the events sent to them."""

from __future__ import annotations

import itertools
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.compiler.model import System, SystemComponent
from rtgen.compiler.systems import conditions
from rtgen.facts.openrtm_ports import KIND, foreign_instances
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.failures import Failure, described
from rtgen.runtime.opaque_rpc.codecs import Codec
from rtgen.runtime.ports.data_ports import DataConnector, OutPort
from rtgen.runtime.system.joining import Connector, instances_of
from rtgen.runtime.system.json_printers import json_printer
from rtgen.runtime.system.records import Record, StateRecord
from rtgen.runtime.timing.clocks import SECOND
from rtgen.runtime.timing.traffic import (
    BoardCall,
    BusFrame,
    ConnectionChange,
    ParameterChange,
)
from rtgen.runtime.timing.traffic import Event as Happening
from rtgen.tools.kit.member_units import MemberUnits
from rtgen.tools.recording.recorder import cdr_encoder
from rtgen.ui import boards, compared_run, connection_properties, description
from rtgen.ui.buses import Buses
from rtgen.ui.changes import Changes
from rtgen.ui.compared_run import ComparedRun
from rtgen.ui.description import (
    STATES,
    Description,
    member_units,
    palette_entry,
    planned,
)
from rtgen.ui.documents.document import Document, DocumentError
from rtgen.ui.edits import Edits
from rtgen.ui.errors import FILE, UNKNOWN, CommandError
from rtgen.ui.flows import Flows
from rtgen.ui.history import History
from rtgen.ui.outbox import Outbox
from rtgen.ui.project import Known, Project, RunWatcher
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.runner import Runner
from rtgen.ui.texts import explained, placed
from rtgen.ui.type_table import NO_TYPE, TypeTable

if TYPE_CHECKING:
    from rtgen.runtime.corba.rt_objects.publishing import RtObjects
    from rtgen.ui.watching import Attach, Key, Watcher

Place = tuple[float, float]
_MAX_NOTICE_LENGTH: Final = 2000
_FLOWS_INTERVAL: Final = 1.0
"""Time between two counts of the samples on connections [s]."""
_BEFORE: Final = "the run before"
"""The name of a kept run, which is compared with the next one."""


class Session:
    """A system, run for pages.

    Only the thread of the runner reads and changes the system; pages join, leave and send commands
    by `Runner.submit`. `clock` creates the clock of a system. `recording` is a file to compare with
    the system. `name_servers` are the addresses of naming services whose components are shown, too.
    `own` has the CORBA objects of the system's components; None if it does not run over CORBA.
    `attach` begins to watch the components of other processes instead.
    """

    def __init__(
        self,
        project: Project,
        file: str,
        clock: Callable[[], runtime.Clock] = runtime.SimulatedClock,
        name_servers: Sequence[str] = (),
        own: RtObjects | None = None,
        recording: str = "",
        attach: Attach | None = None,
    ) -> None:
        """Raise InputError or ToolError if the system cannot be assembled or recorded.

        Raise TransportError if there are `name_servers` and omniORB cannot start.
        """
        self.project = project
        self.file = file
        self.name = uuid.uuid4().hex
        """Identifies this start of the server."""
        self.types = TypeTable()
        self.describe = Description(self.types)
        self.edits: Edits
        self.changes: Changes
        self.is_new = False
        """Whether the system has no file that was opened, so that the present one is saved."""
        self.known: Known
        """The file as it was opened or saved last."""
        self.places: dict[str, Place] = {}
        self.profile: System
        """The system of the file as it was opened or saved last."""
        self._finishing: frozenset[str]
        """The instances whose ERROR is the end of their work."""
        self.foreign: Mapping[str, SystemComponent]
        """The components of other processes in the file, by their paths."""
        self._clock = clock
        self._sent_types = 0
        self._lock = threading.Lock()
        self._pages: tuple[Outbox, ...] = ()
        self._channels: dict[tuple[str, str], ui.Channel] = {}
        self._watched: frozenset[int] = frozenset()
        self._numbers = itertools.count(1)
        self._counts: dict[str, ui.Statistics] = {}
        self._codecs: dict[str, Codec | None] = {}
        self._recorded: ComparedRun | None = None
        if recording:
            describer = project.describer
            self._recorded = compared_run.read(
                recording, self.types, self._numbers, describer
            )
        self.beside: ComparedRun | None = self._recorded
        """The run that pages compare with this one."""
        self.ended = ""
        """Why the run is over; empty while it is not."""
        self.keeps = False
        """Whether this run is kept for comparison when time is set back."""
        self._end_recording: Callable[[], None] = lambda: None
        self.renew_palette()
        self.runner = Runner(self.made(file), self._report, self._ended)
        self.buses: Buses
        self.history: History
        self.flows: Flows
        self._next_flows = 0.0
        self.own = own
        self._across: set[str] = set()
        """Names of the connections to other processes, which `remote` contains."""
        self.remote = RemoteState()
        """The components of other processes."""
        self.watcher: Watcher | None = None
        self._watch()
        if name_servers:
            from rtgen.ui.naming_watcher import NamingWatcher

            self.watcher = NamingWatcher(
                name_servers, self._update_remote, self._report_remote, own
            )
        elif attach is not None:
            self.watcher = attach(self._update_remote, self._report_remote)

    # Systems.

    def renew_palette(self) -> None:
        """Take over the component types that the project has now."""
        self._palette = [palette_entry(each) for each in self.project.palette()]
        self.known_types = frozenset(each.type for each in self._palette)

    @property
    def system(self) -> runtime.System:
        """The running system."""
        return self.runner.system

    def made(self, file: str) -> runtime.System:
        """Create the system of a file, INACTIVE. Raises InputError or ToolError."""
        profile, document = self.project.read(file)
        system = self.assembled(profile)
        self.file = file
        self.is_new = document is None
        self.known = Known(file, None if document is None else document.data)
        self.edits = Edits(document or Document.new(profile.name))
        self.changes = Changes(self.edits, profile, system)
        self.take_over(profile)
        self.places = {
            each.instance: (float(each.location[0]), float(each.location[1]))
            for each in profile.components
            if each.location is not None and each.path_uri not in self.foreign
        }
        return system

    def take_over(self, profile: System) -> None:
        """Use a profile as that of the system from now on."""
        foreign = foreign_instances(profile.properties)
        self._finishing = conditions.finishing(profile)
        self.profile = profile
        self.foreign = {
            each.path_uri: each
            for each in profile.components
            if each.instance in foreign
        }

    def assembled(self, profile: System) -> runtime.System:
        """Create a system from a profile. Raises InputError or ToolError."""
        watcher = RunWatcher(self._failed, self._skipped, self._called)
        return self.project.assemble(profile, self._clock(), watcher)

    def change_system(self, system: runtime.System) -> None:
        """Continue with another system; all pages get its whole state."""
        self._end_recording()
        self.ended = ""
        self._channels.clear()
        self._counts.clear()
        self._codecs.clear()
        self.runner.replace(system)
        self._watch()
        whole = ui.Event.of_whole(self.whole())
        for page in self._pages:
            page.show([whole], None)

    def open(self, file: str) -> None:
        """Continue with the system of another file. Raises CommandError."""
        try:
            system = self.made(file)
        except (InputError, ToolError, OSError) as error:
            raise CommandError(FILE, explained(error)) from error
        self.keeps, self.beside = False, self._recorded
        self.change_system(system)

    def run_again(self) -> None:
        """Restart the run of the file with all edits.

        The current run is kept for comparison if that was requested. Raises InputError, ToolError.
        """
        try:
            written = self.edits.system
        except DocumentError as error:
            raise CommandError(FILE, str(error)) from error
        system = self.assembled(written)
        self.changes = Changes(self.edits, written, system)
        if self.keeps and self.beside is None:
            channels = [*self._channels.values()]
            self.beside = compared_run.kept(
                _BEFORE, self.history, channels, self._numbers
            )
        self.change_system(system)

    def keep(self, *, kept: bool) -> None:
        """Set whether this run is kept for comparison when time is set back."""
        self.keeps = kept
        if not kept or self.beside is self._recorded:
            self.beside = None
        for page in self._pages:
            self.look(page, -1.0 if page.past is None else page.past)

    def _watch(self) -> None:
        system = self.system
        self._end_recording = self.project.record(system)
        self.history = History()
        self.flows = Flows()
        if self.beside is not None:
            self.beside.begin()
        self.buses = Buses(system, self.project.describer, self.publish)
        for instance in system.instances:
            self.channels_of(instance)
        self._open_remote()
        self.history.begin(self.whole())
        system.clock.traffic.watch(partial(self._on_traffic, system))
        system.add_listener(_Listener(self, system))

    # Pages.

    def join(self, page: Outbox) -> None:
        """Send a new page the greeting and the whole state."""
        hello = ui.Hello(version=ui.VERSION, server=self.name, full=page.full)
        page.put(ui.Event.of_greeting(hello))
        self.look(page, -1.0)
        with self._lock:
            self._pages = (*self._pages, page)

    def leave(self, page: Outbox) -> None:
        """Forget a page; from any thread."""
        with self._lock:
            self._pages = tuple(each for each in self._pages if each is not page)
        self.watch_changed()

    def watch_changed(self) -> None:
        """Update the watched channels of all pages; from any thread."""
        self._watched = frozenset().union(*(page.watched for page in self._pages))
        if self.watcher is not None:
            watched = (
                e for e in self._channels.copy().values() if e.id in self._watched
            )
            self.watcher.watch(
                {
                    key: partial(self._take, each.id)
                    for each in watched
                    if (key := self._key(each.port)) is not None
                }
            )

    def _key(self, address: ui.PortAddress) -> Key | None:
        """Return the key of the connection that receives samples from a port of another process."""
        if address.instance not in self.remote.components:
            return None
        from rtgen.ui.watching import Key, Use

        return Key(Use.LISTEN, address.instance, address.port)

    def _take(self, channel: int, data: bytes) -> None:
        """Accept a sample of a component of another process."""
        self.sample(ui.Sample(channel, self.now, data))

    def watch(self, page: Outbox, channels: Sequence[int]) -> None:
        """Set the channels that a page watches, and send it the past samples of new ones.

        Numbers of channels that do not exist are ignored.
        """
        open_channels = (*self._channels.values(), *self._channels_beside)
        watched = frozenset(channels).intersection(each.id for each in open_channels)
        added = watched - page.watched
        page.watched = watched
        self.watch_changed()
        until = self.now if page.past is None else page.past
        page.show_more(self.history.samples(until, added))

    def look(self, page: Outbox, time: float) -> None:
        """Show a page the run as of a time [s]; negative: the present, from now on.

        The run continues.
        """
        self.history.reach(self.now)
        now = self.history.nearest(self.now if time < 0 else time)
        events = self.history.at(now, self.types.nodes, page.watched)
        if time < 0:
            events[0] = ui.Event.of_whole(self.whole())
            events.append(ui.Event.of_flows(self.flows.latest))
        else:
            whole = events[0].whole
            beside = self._channels_beside
            own = [each for each in whole.channels if not each.beside]
            whole.beside, whole.keeps = self._name_beside, self.keeps
            whole.channels = [*own, *beside]
        page.show(events, None if time < 0 else now)

    def publish(self, *events: ui.Event) -> None:
        """Put events into the outbox of each page, after new types."""
        for event in events:
            self.history.add(self.now, event)
        nodes = self.types.nodes
        if len(nodes) > self._sent_types:
            first, self._sent_types = self._sent_types, len(nodes)
            added = ui.AddedTypes(first=first, nodes=nodes[first:])
            self._to_all(ui.Event.of_types(added))
        self._to_all(*events)

    def _to_all(self, *events: ui.Event) -> None:
        for page in self._pages:
            page.put(*events)

    def whole(self) -> ui.SystemState:
        """Return the whole state."""
        system = self.system
        remote = self.remote
        shown = (*system.instances, *remote.components)
        components = [self.component(each) for each in shown]
        self._sent_types = len(self.types.nodes)
        return ui.SystemState(
            name=self.profile.name,
            types=[*self.types.nodes],
            components=components,
            connections=[
                *(description.connection(c) for c in self.connectors),
                *remote.connections.values(),
            ],
            palette=self._palette,
            channels=[*self._channels.values(), *self._channels_beside],
            time=self.time(),
            edits=self.edit_state(),
            buses=self.buses.states,
            systems=[*self.project.systems],
            beside=self._name_beside,
            keeps=self.keeps,
            naming=[*remote.services],
            foreign=[*self.foreign],
            plan=[*map(planned, self.project.timeline(self.profile).steps)],
            doc=self.profile.abstract,
            properties=connection_properties.parameters(),
        )

    @property
    def _name_beside(self) -> str:
        return "" if self.beside is None else self.beside.name

    @property
    def _channels_beside(self) -> list[ui.Channel]:
        return [] if self.beside is None else [*self.beside.channels.values()]

    @property
    def connectors(self) -> list[Connector]:
        """The connections within the system; those to other processes are in `remote`."""
        return [each for each in self.system.connectors if self._is_within(each)]

    def _is_within(self, connector: Connector) -> bool:
        return {*self.system.instances}.issuperset(instances_of(connector))

    def component(self, instance: str) -> ui.Component:
        """Describe a component of this process or another one."""
        place = self.places.get(instance)
        remote = self.remote.components.get(instance)
        if remote is None:
            finishes = instance in self._finishing
            return self.describe.component(
                self.system, instance, place, finishes=finishes
            )
        where = ui.Location(*(place or (0.0, 0.0)))
        return replace(remote, placed=place is not None, where=where)

    def _update_remote(self, state: RemoteState) -> bool:
        """Publish the changes in other processes; from any thread."""

        def update() -> None:
            before, self.remote = self.remote, state.known(self._completed)
            for instance in before.components.keys() - self.remote.components.keys():
                self.forget(instance)
            for instance in self.remote.components.keys() - before.components.keys():
                component = self.foreign.get(f"{instance}.{KIND}")
                if component is not None and component.location is not None:
                    x, y = component.location[:2]
                    self.places.setdefault(instance, (float(x), float(y)))
            opened = self._open_remote()
            changes = self.remote.changes(before, self.now)
            self.publish(*map(self._placed, changes), *map(ui.Event.of_opened, opened))
            self.watch_changed()

        return self.runner.submit(update)

    def _report_remote(self, instance: str, text: str) -> None:
        self.runner.submit(lambda: self.notice("error", instance, text))

    def _completed(self, port: ui.Port) -> ui.Port:
        """Return a port of another process, completed with the project's types."""
        number, units = NO_TYPE, port.units
        if port.type and (type_ := self.project.data_type(port.type)) is not None:
            number = self.describe.type_number(type_)
            units = member_units(MemberUnits(type_, port.unit))
        interfaces = [
            (
                replace(each, operations=self.describe.operations(interface))
                if each.provided and (interface := self.project.interface(each.type))
                else each
            )
            for each in port.interfaces
        ]
        return replace(port, type_number=number, units=units, interfaces=interfaces)

    def _open_remote(self) -> list[ui.Channel]:
        """Return the channels of new OutPorts of other processes."""
        channels = []
        for instance, component in self.remote.components.items():
            for port in component.ports:
                key = instance, port.name
                is_open = port.kind is ui.PortKind.PORT_OUT and port.type_number >= 0
                if is_open and key not in self._channels:
                    address = ui.PortAddress(instance=instance, port=port.name)
                    channel = ui.Channel(next(self._numbers), address, port.type_number)
                    self._channels[key] = channel
                    channels.append(channel)
        return channels

    def _placed(self, event: ui.Event) -> ui.Event:
        """Add the place of its box to an event about a component of another process."""
        if event.discriminator is not ui.EventKind.EVENT_COMPONENT:
            return event
        return ui.Event.of_described(self.component(event.described.instance))

    def time(self) -> ui.ClockState:
        """Return the state of the clock."""
        runner = self.runner
        kinds = ui.ClockKind.CLOCK_REAL, ui.ClockKind.CLOCK_SIMULATED
        return ui.ClockState(
            kind=kinds[runner.is_simulated],
            playing=runner.playing,
            speed=runner.speed,
            now=self.now,
            ended=runner.over,
            reason=self.ended,
            first=self.history.first,
            last=self.now,
        )

    @property
    def now(self) -> float:
        """Seconds since the start of the run."""
        return self.system.time / SECOND

    def edit_state(self) -> ui.EditState:
        """Return which edits can be undone, and whether the file contains all edits."""
        return ui.EditState(
            undo=self.edits.undo_label,
            redo=self.edits.redo_label,
            saved=self.edits.saved,
            file=self.file,
        )

    def publish_edits(self) -> None:
        """Report to pages which edits can be undone."""
        self.publish(ui.Event.of_edited(self.edit_state()))

    # Events of the system.

    def channels_of(self, instance: str) -> list[ui.Channel]:
        """Return the channels of a component's OutPorts, opening new ones."""
        channels = []
        for name, port in self.system.component(instance).out_ports.items():
            if (instance, name) not in self._channels:
                self._channels[instance, name] = ui.Channel(
                    id=next(self._numbers),
                    port=ui.PortAddress(instance=instance, port=name),
                    type_number=self.describe.type_number(port.type),
                )
            channels.append(self._channels[instance, name])
        return channels

    def forget(self, instance: str) -> None:
        """Forget a removed component."""
        self.places.pop(instance, None)
        self._counts.pop(instance, None)
        for key in [key for key in self._channels if key[0] == instance]:
            del self._channels[key]

    def port_names(self, instance: str) -> list[str]:
        """Return the names of a component's ports, each once."""
        component = self.system.component(instance)
        services = (port for port, _ in (*component.providers, *component.consumers))
        return [*dict.fromkeys((*component.in_ports, *component.out_ports, *services))]

    def require_port(self, instance: str, port: str) -> None:
        """Raise CommandError or RtcError if the port does not exist."""
        if port not in self.port_names(instance):
            raise CommandError(UNKNOWN, f"{instance} has no port {port!r}")

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """Return a writer that sends the samples of a port to the pages that watch it."""
        channel = self._channels.get((port.owner, port.name))
        if channel is None:
            self.channels_of(port.owner)
            channel = self._channels[port.owner, port.name]
        number = channel.id
        encode: Any = cdr_encoder(port.type)
        if channel.type_number < 0 or encode is None:
            printed = json_printer(port.type)

            def encode(value: Any) -> bytes:
                return printed(value).encode()

        def write(value: Any) -> None:
            try:
                data = encode(value)
            except CdrError:
                return  # The recorder counts invalid samples; pages cannot show them.
            self.sample(ui.Sample(number, elapsed() / SECOND, data))

        return write

    def sample(self, sample: ui.Sample) -> None:
        """Keep a sample, and send it to the pages that watch its channel; from any thread."""
        self.history.sample(sample)
        self.flows.written(sample.channel)
        if sample.channel not in self._watched:
            return
        for page in self._pages:
            if sample.channel in page.watched:
                page.sample(sample)

    def on_state(self, record: StateRecord) -> None:
        """Publish a change of state."""
        self.publish(
            ui.Event.of_change(
                ui.StateChange(
                    time=record.time / SECOND,
                    instance=record.instance,
                    handle=record.ec_id,
                    before=STATES[record.before],
                    after=STATES[record.after],
                    reason=record.reason,
                )
            )
        )

    def _on_traffic(self, system: runtime.System, happening: Happening) -> None:
        if system is not self.system:
            return  # The system is being closed.
        match happening:
            case ParameterChange(instance) if instance not in system.instances:
                pass  # It is being added, and is described afterwards.
            case ParameterChange(instance, parameter, value):
                sets = self.system.component(instance).configuration_sets
                change = ui.ParameterChange(
                    instance=instance,
                    set=sets.active,
                    parameter=parameter,
                    text=value,
                    effective=True,
                )
                self.publish(ui.Event.of_setting(change))
            case ConnectionChange(name, connected=True):
                self._codecs.clear()
                connector = self.system.connector(name)
                if not self._is_within(connector):
                    self._across.add(name)
                    return
                self.publish(ui.Event.of_connected(description.connection(connector)))
            case ConnectionChange(name) if name in self._across:
                self._across.discard(name)
            case ConnectionChange(name):
                self.publish(ui.Event.of_cut(name))
            case BusFrame():
                self.buses.on_frame(happening, self.now)
            case BoardCall(instance, request, reply, error, duration):
                call = ui.BoardCall(
                    time=self.now,
                    instance=instance,
                    request=request,
                    reply=reply,
                    round_trip=duration / SECOND,
                    error=error,
                )
                if codec := self._codec(instance):
                    boards.describe(call, codec)
                self.publish(ui.Event.of_call(call))

    def _codec(self, communication: str) -> Codec | None:
        """Return the codec of the marshaller that is connected to a communication RTC."""
        if communication not in self._codecs:
            ends = (
                self.system.component(each)
                for connector in self.connectors
                if communication in (pair := instances_of(connector))
                for each in pair
            )
            codec = next(filter(None, map(boards.codec_of, ends)), None)
            self._codecs[communication] = codec
        return self._codecs[communication]

    def notice(self, kind: str, instance: str, text: str) -> None:
        """Add a notice to the timeline."""
        notice = ui.Notice(
            time=self.now, kind=kind, instance=instance, text=text[:_MAX_NOTICE_LENGTH]
        )
        self.publish(ui.Event.of_reported(notice))

    def _failed(self, failure: Failure) -> None:
        if failure.error is None and failure.instance in self._finishing:
            return  # The change of state says that it has finished, and why.
        what = failure.reason if failure.error is None else described(failure.error)
        self.notice("error", failure.instance, f"{failure.callback}: {what}")

    def _called(self, instance: str, text: str) -> None:
        self.notice("call", instance, text)

    def _skipped(self, finding: Diagnostic) -> None:
        self.notice("skipped", "", placed(finding))

    def _ended(self, error: BaseException) -> None:
        self.ended = explained(error)[:_MAX_NOTICE_LENGTH]
        self.notice("end", "", self.ended)
        at = f"the run has ended at {self.now:.3f} s"
        self.project.report_end(f"{at}: {self.ended}")
        self.publish(ui.Event.of_clock(self.time()))

    def _report(self) -> None:
        """Publish the time, events of the compared run, and changed statistics."""
        if self.beside is not None:
            events, samples = self.beside.until(self.now)
            self.publish(*events)
            for sample in samples:
                self.sample(sample)
        if not self._pages:
            return
        if self.runner.playing:
            self.publish(ui.Event.of_clock(self.time()))
        changed = []
        for each in description.statistics(self.system, self.system.instances):
            before = self._counts.get(each.instance)
            if each != before:
                self._counts[each.instance] = each
                changed.append(each)
                if before is not None and each.overruns > before.overruns:
                    count = each.overruns - before.overruns
                    self.notice("overrun", each.instance, f"{count} more")
        self.history.statistics(self.now, changed)
        if self._is_time_for_flows() and self.flows.changed(
            self.now, self.connectors, self.source_channel
        ):
            self._to_all(ui.Event.of_flows(self.flows.latest))
        for page in self._pages:
            if changed:
                page.statistics(changed)
            if page.missed_changes:
                page.put(ui.Event.of_whole(self.whole()))

    def _is_time_for_flows(self) -> bool:
        now = monotonic()
        if now < self._next_flows:
            return False
        self._next_flows = now + _FLOWS_INTERVAL
        return True

    def source_channel(self, connector: DataConnector[Any]) -> int | None:
        """Return the number of the channel of the OutPort of a connection."""
        source = connector.source
        channel = self._channels.get((source.owner, source.name))
        return None if channel is None else channel.id

    def close(self) -> None:
        """Notify the pages, and end the run."""
        self._to_all(ui.Event.of_reason("the server has ended"))
        self._end_recording()
        if self.watcher is not None:
            self.watcher.close()
        self.runner.close()


class _Listener:
    """Listener for the events of the system."""

    def __init__(self, session: Session, system: runtime.System) -> None:
        self.sample_writer = session.sample_writer
        self._session = session
        self._system = system

    def __call__(self, record: Record) -> None:
        # A closing system is no longer shown.
        if isinstance(record, StateRecord) and self._session.system is self._system:
            self._session.on_state(record)
