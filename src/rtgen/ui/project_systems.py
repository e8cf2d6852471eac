"""The project of the systems that `rtgen ui` runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rtgen import runtime
from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    ToolError,
    has_errors,
    in_order,
)
from rtgen.compiler.frontends.profiles import profile_tree, rts_profile
from rtgen.compiler.judging import Judge
from rtgen.compiler.model import PortReference, System, SystemComponent
from rtgen.compiler.project import (
    Project,
    is_bus_file,
    is_system,
    load_around,
    shown,
)
from rtgen.compiler.project.cache import default
from rtgen.compiler.systems import conditions, timeline
from rtgen.compiler.systems.checks import check_properties
from rtgen.compiler.systems.rules import MEASURE, NOTICE
from rtgen.compiler.systems.timeline import Timeline
from rtgen.facts.files import absolute_path
from rtgen.runtime.failures import Failure, log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.runtime.services.servants import Servant
from rtgen.tools.components.known_types import KnownTypes
from rtgen.tools.kit.console import Console
from rtgen.tools.running.assembly import add_component, assemble
from rtgen.tools.running.factories import Factories, FactoryImportError
from rtgen.tools.running.failures import FailureOptions, FailureReport
from rtgen.tools.running.foreign import named
from rtgen.tools.running.partition import alone, steps_here
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.ui.documents.storing import OtherContentError, store
from rtgen.ui.errors import FILE, QUESTION, CommandError

if TYPE_CHECKING:
    from rtgen.runtime.corba.transport import NamedCorba
    from rtgen.runtime.opaque_rpc.codecs import Codec
    from rtgen.tools.renaming.plan import Renaming
    from rtgen.ui.bus_description import BusDescriber
    from rtgen.ui.project import Known, Opened, RunWatcher

_SUFFIXES = (".xml", ".yaml", ".yml")
_RECORDING = ".mcap"
_MAX_RECORDINGS = 100


class CommandProject:
    """The project of the systems on the command line, and how they are created."""

    def __init__(
        self,
        console: Console,
        files: Sequence[str],
        buses: Mapping[str, Path] | None = None,
        transport: NamedCorba | None = None,
        recording: RecordingOptions | None = None,
        check_values: str = "first",
    ) -> None:
        self._console = console
        self._recording = recording or RecordingOptions(None, None)
        self._check_values = check_values
        self._runs = 0
        self._buses = buses or {}
        self._transport = transport
        self._files = [*files]
        self._plans: dict[str, Timeline] = {}
        """The timelines of systems as opened, by their files."""
        self._load()

    def _load(self) -> None:
        self._project = self._loaded()
        self._judge = Judge(self._project, default())
        self._factories = Factories(self._project)
        self._types = KnownTypes(self._project)

    def _loaded(self) -> Project:
        return load_around(Path(self._files[0]) if self._files else Path.cwd())

    @property
    def systems(self) -> Sequence[str]:
        """The files that can be opened: the systems on the command line."""
        return self._files

    @property
    def recordings(self) -> Sequence[str]:
        """The recordings that can be compared with a run, the latest first.

        They are in the working folder, and beside the systems of the command line.
        """
        files: dict[Path, float] = {}
        for folder in self._roots():
            with suppress(OSError):
                for path in folder.glob(f"*{_RECORDING}"):
                    files[path] = path.stat().st_mtime
        latest = sorted(files, key=lambda each: files[each], reverse=True)
        return [shown(each) for each in latest[:_MAX_RECORDINGS]]

    def recording(self, name: str) -> str:
        """Return the file of a recording below those folders. Raises CommandError."""
        path = Path(name).resolve()
        inside = any(path.is_relative_to(each) for each in self._roots())
        if path.suffix.lower() != _RECORDING or not inside:
            raise CommandError(
                FILE,
                f"{name} is not a recording of the project",
                f"a file {_RECORDING} in the working folder, or beside the system",
            )
        return str(path)

    def _roots(self) -> list[Path]:
        beside = (Path(each).resolve().parent for each in self._files)
        return [Path.cwd().resolve(), *beside]

    def read(self, file: str) -> Opened:
        """Return the system of a file or folder; without one, a system without components.

        Raises InputError.
        """
        from rtgen.ui.documents.document import Document
        from rtgen.ui.project import Opened

        if not file:
            return Opened(Document.new("").system(()), None)
        path = _path_of(file)
        name = path.as_posix()
        sink = profile_tree.sink()
        data = profile_tree.read(path, name, sink.report)
        result = rts_profile.SystemResult(None, sink.diagnostics, {})
        if data is not None:
            result = rts_profile.load_bytes(data, name)
        profile, diagnostics, sources = result
        diagnostics = (
            *diagnostics,
            *(check_properties(profile) if profile is not None else ()),
        )
        if profile is None or data is None or has_errors(diagnostics):
            raise InputError(in_order(diagnostics))
        self._console.findings(in_order(diagnostics), sources)
        plan = _timeline(profile)
        self._console.findings(plan.skipped)
        judgement = self._judge.of_system(profile, plan.steps)
        doubts = _without_notes(judgement.diagnostics)
        if judgement.failed:
            raise InputError(in_order(doubts))
        self._console.findings(in_order(doubts), judgement.sources)
        self._plans[profile.file] = plan
        return Opened(profile, Document(name, data))

    def write(self, file: str, data: bytes, own: Known, *, replace: bool) -> str:
        """Write a system, below the working folder or beside a system of the command line.

        Only a file that describes a system is replaced. `own` is the file of the session. Other
        content than that is only replaced if `replace`; then it is kept in another file, whose name
        is returned, else an empty text. Raises CommandError, with QUESTION if the user must decide.
        """
        path = _path_of(file).resolve()
        inside = any(path.is_relative_to(each) for each in self._roots())
        if path.suffix.lower() not in _SUFFIXES or not inside:
            raise CommandError(
                FILE,
                f"{file} is not an XML or YAML file of the project",
                f"a name that ends in {', '.join(_SUFFIXES)}, beside the system",
            )
        if path.exists() and not is_system(path):
            raise CommandError(FILE, f"{file} exists and is not a system")
        is_own = own.file != "" and _path_of(own.file).resolve() == path
        content = own.data if is_own else None
        try:
            backup = store(path, data, content, replace=replace)
        except OtherContentError as error:
            hint = "its content stays in a file beside it if it is replaced"
            raise CommandError(QUESTION, f"{file}: {error}", hint) from error
        except OSError as error:
            message = f"cannot write {file}: {error.strerror}"
            raise CommandError(FILE, message) from error
        return "" if backup is None else shown(backup)

    def timeline(self, profile: System) -> Timeline:
        """Return the timeline of a system of `read`."""
        return self._plans.get(profile.file, Timeline())

    def renaming(self, old: str, new: str) -> Renaming:
        """Plan a rename of what a definition names. Raises InputError."""
        from rtgen.tools.renaming import plan

        return plan.by_names(self._loaded, old, new)

    def renaming_of_instance(self, file: str, instance: str, name: str) -> Renaming:
        """Plan a rename of a component of a system's file. Raises InputError."""
        from rtgen.tools.renaming import plan

        key = f"rts {absolute_path(_path_of(file).as_posix())}#{instance}"
        return plan.by_key(self._loaded, key, name, {}, {})

    def rename(self, renaming: Renaming) -> None:
        """Change the files of a rename, and those generated from them; systems are read anew.

        Raises InputError, ToolError.
        """
        from rtgen.tools.compiling.generation import generate_project
        from rtgen.tools.renaming import writing

        writing.write(renaming)
        project = self._loaded()
        if project.file is not None and project.sources:
            generate_project(project, default())
        self._factories.forget()
        self._load()

    def refusals(self, profile: System) -> Sequence[str]:
        """Return the errors that `rtgen run` would report before the start."""
        from rtgen.ui.texts import placed

        plan = self.timeline(profile)
        found = [*check_properties(profile)]
        found += self._judge.of_system(profile, plan.steps).diagnostics
        problems = [d for d in found if d.severity is Severity.ERROR]
        try:
            poses = conditions.listed(profile, conditions.POSE)
            problems += (
                MEASURE.at(each.span, f"{name!r} is not a pose of the system")
                for each in _timeline(profile).measures
                for name in each.observables
                if name not in poses
            )
        except InputError as error:
            problems += error.diagnostics
        return [placed(each) for each in problems]

    def judged(
        self,
        source: PortReference,
        target: PortReference,
        types: Mapping[str, str],
        properties: Mapping[str, str],
    ) -> Sequence[Diagnostic]:
        """Return warnings and errors about joining two ports, by the definitions of the project.

        `types` has the types of the two instances.
        """
        return _without_notes(self._judge.of_ends(source, target, types, properties))

    def assemble(
        self, profile: System, clock: runtime.Clock, watcher: RunWatcher
    ) -> runtime.System:
        """Return a system with the timeline of its file as opened.

        Nothing is activated before time passes. Foreign components and their connections are
        omitted. Raises InputError, ToolError.
        """
        simulated = isinstance(clock, runtime.SimulatedClock)
        report = FailureReport(self._console, FailureOptions(), simulated=simulated)
        steps = self.timeline(profile).steps
        if outside := named(profile, None, self._factories.foreign):
            here = {c.instance for c in profile.components} - outside
            steps = steps_here(steps, profile, here, data=True)
            profile = alone(profile, here)

        def skipped(finding: Diagnostic) -> None:
            report.notice(finding)
            watcher.skipped(finding)

        report.on_call = watcher.called
        system = assemble(
            profile,
            self._factories,
            clock,
            (),
            steps,
            self._transport,
            report=report,
            skipped=skipped,
            check_values=self._check_values,
        )

        def on_failure(failure: Failure) -> None:
            report(failure)
            watcher.failed(failure)

        system.on_failure = on_failure
        return system

    def report_end(self, reason: str) -> None:
        """Print that a run has ended by an error, and why."""
        report = FailureReport(self._console, FailureOptions())
        report.notice(NOTICE.at(None, reason))

    def add(
        self, system: runtime.System, component: SystemComponent, folder: Path
    ) -> None:
        """Add a component whose type has a factory to a running system, whose file is in a folder.

        Raises InputError, ToolError.
        """
        report = FailureReport(self._console, FailureOptions())
        add_component(system, component, self._factories, folder, report)

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record a run from now on, if runs are recorded; return a function that ends it.

        Each has a file of its own: `FILE.mcap`, `FILE-2.mcap`, ...
        """
        self._runs += 1
        options = self._recording.numbered(self._runs)
        files = ExitStack()
        recorder = options.begin(files, system)

        def end() -> None:
            if recorder is not None:
                recorder.end(through=True)
            options.tell(self._console, recorder)
            files.close()
            options.name_file(self._console)

        return end

    def describer(self, bus: str, network: str) -> BusDescriber:
        """Return the description of a bus.

        That is the file for its channel, else the default one, else the one of its network in the
        project.
        """
        from rtgen.ui.bus_description import BusDescriber

        named = self._buses.get(bus, self._buses.get(""))
        if named is None and network:
            for path in filter(is_bus_file, self._project.sources):
                try:
                    buses = BusDescriber(path)
                except InputError:
                    continue  # `rtgen lint` reports its errors
                if buses.network == network:
                    return buses
        return BusDescriber(named)

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type of the project or of OpenRTM; None if unknown.

        `name` is its scoped name or the last part of that.
        """
        return self._types.data_type(name)

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface of the project by its name, as that of a type; None if unknown."""
        return self._types.interface(name)

    def codec(self, type_: str) -> Codec | None:
        """Return the codec of a marshaller type; None for another type, which is not created."""
        from rtgen.ui import boards

        if type_ not in self._factories:
            return None
        try:
            factory = self._factories[type_]
        except ToolError as error:
            log.warning("calls to boards have no values: %s", error)
            return None
        if not boards.is_marshaller(factory):
            return None
        component = factory(type_)
        component.on_initialize()
        return boards.codec_of(component)

    def palette(self) -> Sequence[ComponentProfile]:
        """Return the component types of which pages can add instances.

        Their factories are importable classes.
        """
        components = []
        for name in sorted(self._factories.types):
            try:
                profile = getattr(self._factories[name], "profile", None)
            except (FactoryImportError, ToolError):
                continue  # `rtgen run` reports it if a system needs the type.
            if isinstance(profile, ComponentProfile):
                components.append(msgspec.structs.replace(profile, type_name=name))
        return components


def _without_notes(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    return [each for each in findings if each.severity is not Severity.NOTE]


def _path_of(file: str) -> Path:
    """Return the path of a system's file, also of one in a folder."""
    path = Path(file)
    return path / "system.xml" if file and path.is_dir() else path


def _timeline(profile: System) -> Timeline:
    """Return the timeline beside a system of a folder."""
    path = Path(profile.file)
    folder = path.parent if path.name == "system.xml" else path
    return timeline.of_system(folder, None, profile)
