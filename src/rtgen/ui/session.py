"""A session: one system that pages show and change, its pages, and the events sent to them."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError, ToolError
from rtgen.compiler.model import System, SystemComponent
from rtgen.compiler.systems import conditions
from rtgen.facts.openrtm_ports import foreign_instances
from rtgen.runtime.failures import Failure
from rtgen.runtime.system.joining import Connector, instances_of
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.running.bus_access import BusAccess
from rtgen.ui import compared_run
from rtgen.ui.buses import Buses
from rtgen.ui.changes import Changes
from rtgen.ui.channels import Channels
from rtgen.ui.compared_run import ComparedRun, Comparison
from rtgen.ui.description import Description, palette_entry
from rtgen.ui.documents.document import Document, DocumentError
from rtgen.ui.edits import Edits
from rtgen.ui.errors import FILE, CommandError
from rtgen.ui.flows import Chains, Flows
from rtgen.ui.history import History
from rtgen.ui.other_processes import OtherProcesses
from rtgen.ui.outbox import Outbox
from rtgen.ui.pages import Pages
from rtgen.ui.project import Known, RunWatcher
from rtgen.ui.protocol import ui
from rtgen.ui.remote_state import RemoteState
from rtgen.ui.reports import Reports
from rtgen.ui.runner import Runner
from rtgen.ui.system_events import SystemEvents
from rtgen.ui.system_state import whole
from rtgen.ui.texts import explained, placed
from rtgen.ui.type_table import TypeTable

if TYPE_CHECKING:
    from rtgen.runtime.corba.rt_objects.publishing import RtObjects
    from rtgen.ui.project_systems import CommandProject
    from rtgen.ui.watching import Attach

Place = tuple[float, float]
_MAX_NOTICE_LENGTH: Final = 2000


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
        project: CommandProject,
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
        self.pages = Pages()
        self.channels = Channels()
        run = self.read_beside(recording) if recording else None
        if run is not None:
            run.enter_types(self.types)
        self.beside = Comparison(run)
        self.ended = ""
        """Why the run is over; empty while it is not."""
        self._end_recording: Callable[[], None] = lambda: None
        self.renew_palette()
        self.runner = Runner(self.made(file), self._report, self._ended)
        self.buses: Buses
        self.history: History
        self.flows: Flows
        self.chains: Chains
        self.own = own
        self.others = OtherProcesses(self)
        self._watch()
        if name_servers:
            from rtgen.ui.naming_watcher import NamingWatcher

            self.others.follow(partial(NamingWatcher, name_servers, own=own))
        elif attach is not None:
            self.others.follow(attach)

    # Systems.

    def renew_palette(self) -> None:
        """Take over the component types that the project has now."""
        self.palette = [palette_entry(each) for each in self.project.palette()]

    @property
    def system(self) -> runtime.System:
        """The running system."""
        return self.runner.system

    @property
    def remote(self) -> RemoteState:
        """The components of other processes."""
        return self.others.state

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
        self.channels.clear()
        self.runner.replace(system)
        self._watch()
        whole = ui.Event.of_whole(self.whole())
        for page in self.pages:
            page.show([whole], None)

    def open(self, file: str) -> None:
        """Continue with the system of another file. Raises CommandError."""
        try:
            system = self.made(file)
        except (InputError, ToolError, OSError) as error:
            raise CommandError(FILE, explained(error)) from error
        self.beside.open()
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
        self.beside.end(self.history, self.channels)
        self.change_system(system)

    def keep(self, *, kept: bool) -> None:
        """Set whether this run is kept for comparison when time is set back."""
        self.beside.keep(kept=kept)
        self._look_again()

    def read_beside(self, file: str) -> ComparedRun:
        """Read a recording, for `compare`; from any thread. Raises ToolError."""
        return compared_run.read(file, self.channels.numbers, self.project.describer)

    def compare(self, run: ComparedRun | None) -> None:
        """Compare a recording with this run and the next ones, or nothing."""
        if run is not None:
            run.enter_types(self.types)
        self.beside.take(run)
        self._look_again()

    def _look_again(self) -> None:
        for page in self.pages:
            self.look(page, -1.0 if page.past is None else page.past)

    def _settings(self) -> Iterator[Mapping[str, str]]:
        """Yield the values of the parameters of each component."""
        for instance in self.system.instances:
            sets = self.system.component(instance).configuration_sets
            yield sets.texts(sets.active)
        yield from self.others.settings

    def _watch(self) -> None:
        system = self.system
        self._end_recording = self.project.record(system)
        self.history = History()
        self.flows = Flows()
        self.chains = Chains(system)
        self._reports = Reports(self)
        if self.beside.run is not None:
            self.beside.run.begin()
        access = BusAccess(system)
        self.buses = Buses(self.project.describer, self._settings, self.publish, access)
        watcher = self.others.watcher
        if watcher is not None and watcher.access is not None:
            self.buses.access = watcher.access
        for instance in system.instances:
            self.channels_of(instance)
        self.others.open()
        self.history.first = self.history.last = self.others.time or 0.0
        self.history.begin(self.whole())
        self._events = SystemEvents(self, system)

    # Pages.

    def join(self, page: Outbox) -> None:
        """Send a new page the greeting and the whole state."""
        hello = ui.Hello(version=ui.VERSION, server=self.name, full=page.full)
        self.look(page, -1.0, ui.Event.of_greeting(hello))
        self.pages.add(page)

    def leave(self, page: Outbox) -> None:
        """Forget a page; from any thread."""
        self.pages.remove(page)
        self.watch_changed()

    def watch_changed(self) -> None:
        """Update the watched channels of all pages; from any thread."""
        watched = self.pages.watched_now()
        channels = self.channels.copy().values()
        self.others.watch(e for e in channels if e.id in watched)

    def watch(self, page: Outbox, channels: Sequence[int]) -> None:
        """Set the channels that a page watches, and send it the past samples of new ones.

        Numbers of channels that do not exist are ignored.
        """
        open_channels = (*self.channels.values(), *self.beside.channels)
        watched = frozenset(channels).intersection(each.id for each in open_channels)
        added = watched - page.watched
        page.watched = watched
        self.watch_changed()
        until = self.now if page.past is None else page.past
        page.show_more(self.history.samples(until, added))

    def look(self, page: Outbox, time: float, *first: ui.Event) -> None:
        """Show a page the run as of a time [s]; negative: the present, from now on.

        Events before it arrive in the same message. The run continues.
        """
        self.history.reach(self.now)
        now = self.history.nearest(self.now if time < 0 else time)
        events = self.history.at(now, self.types.nodes, page.watched)
        if time < 0:
            events[0] = ui.Event.of_whole(self.whole())
            events.append(ui.Event.of_flows(self.flows.latest))
            events.append(ui.Event.of_chains(self.chains.latest))
        else:
            whole = events[0].whole
            own = [each for each in whole.channels if not each.beside]
            whole.beside, whole.keeps = self.beside.name, self.beside.keeps
            whole.channels = [*own, *self.beside.channels]
        page.show([*first, *events], None if time < 0 else now)

    def publish(self, *events: ui.Event) -> None:
        """Put events into the outbox of each page, after new types."""
        for event in events:
            self.history.add(self.now, event)
        self.pages.put(self.types.nodes, events)

    def whole(self) -> ui.SystemState:
        """Return the whole state."""
        state = whole(self)
        self.pages.sent_types = len(state.types)
        return state

    @property
    def connectors(self) -> list[Connector]:
        """The connections within the system; those to other processes are in `remote`."""
        return [each for each in self.system.connectors if self.is_within(each)]

    def is_within(self, connector: Connector) -> bool:
        """Return whether both ends of a connection are in this process."""
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

    def time(self) -> ui.ClockState:
        """Return the state of the clock."""
        runner = self.runner
        kinds = ui.ClockKind.CLOCK_REAL, ui.ClockKind.CLOCK_SIMULATED
        return ui.ClockState(
            kind=kinds[runner.is_simulated],
            playing=runner.playing and not self.remote.run.ended,
            speed=runner.speed,
            now=self.now,
            ended=runner.over or bool(self.remote.run.ended),
            reason=self.ended or self.remote.run.ended,
            first=self.history.first,
            last=self.now,
        )

    @property
    def now(self) -> float:
        """Seconds since the start of the run."""
        elsewhere = self.others.time
        return self.system.time / SECOND if elsewhere is None else elsewhere

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
        return [
            self.channels.opened(instance, name, self.describe.type_number(port.type))
            for name, port in self.system.component(instance).out_ports.items()
        ]

    def forget(self, instance: str) -> None:
        """Forget a removed component."""
        self.places.pop(instance, None)
        self._reports.forget(instance)
        self.channels.forget(instance)

    def sample(self, sample: ui.Sample) -> None:
        """Keep a sample, and send it to the pages that watch its channel; from any thread."""
        self.history.sample(sample)
        self.flows.written(sample.channel)
        self.pages.sample(sample)

    def notice(self, kind: str, instance: str, text: str) -> None:
        """Add a notice to the timeline."""
        notice = ui.Notice(
            time=self.now, kind=kind, instance=instance, text=text[:_MAX_NOTICE_LENGTH]
        )
        self.publish(ui.Event.of_reported(notice))

    def _failed(self, failure: Failure) -> None:
        if failure.error is None and failure.instance in self._finishing:
            return  # The change of state says that it has finished, and why.
        self.notice("error", failure.instance, failure.text)

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
        self._reports.send()

    def close(self) -> None:
        """Notify the pages, and end the run."""
        self.pages.put_in_all(ui.Event.of_reason("the server has ended"))
        self._end_recording()
        self.others.close()
        self.runner.close()
