"""The command `rtgen ui`: runs a system and shows it in a browser."""

from __future__ import annotations

import asyncio
import os
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from rtgen import runtime
from rtgen.cli.common import (
    OK,
    Console,
    Place,
    Refusal,
    WholeRange,
    with_console,
    write_out,
)
from rtgen.cli.components.known_types import KnownTypes
from rtgen.cli.running.assembly import add_component, assemble
from rtgen.cli.running.factories import Factories, FactoryImportError
from rtgen.cli.running.failures import FailureOptions, FailureReport
from rtgen.cli.running.foreign import named
from rtgen.cli.running.partition import alone, steps_here
from rtgen.cli.running.recording_options import RecordingOptions, with_recording
from rtgen.cli.signals import terminable
from rtgen.diagnostics import InputError, ToolError, has_errors, in_order
from rtgen.model import System, SystemComponent
from rtgen.project import is_bus_file, load_around
from rtgen.runtime.failures import Failure, log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.rtc.profiles import ComponentProfile
from rtgen.runtime.services.servants import Servant
from rtgen.systems import timeline
from rtgen.systems.checks import check_properties
from rtgen.systems.reading import read_file

if TYPE_CHECKING:
    from rtgen.cli.ui_bus import BusDescriber
    from rtgen.runtime.corba.transport import CorbaTransport
    from rtgen.runtime.opaque_rpc.codecs import Codec
    from rtgen.ui.session import Session

_LOOPBACK = "127.0.0.1"
_SUFFIXES = (".xml", ".yaml", ".yml")


class CommandProject:
    """The project of the systems on the command line; see `rtgen.ui.project.Project`."""

    def __init__(
        self,
        console: Console,
        files: Sequence[str],
        buses: Mapping[str, Path] | None = None,
        transport: CorbaTransport | None = None,
        recording: RecordingOptions | None = None,
    ) -> None:
        self._console = console
        self._recording = recording or RecordingOptions(None, None)
        self._runs = 0
        self._buses = buses or {}
        self._transport = transport
        self._files = [*files]
        self._project = load_around(Path(files[0]) if files else Path.cwd())
        self._factories = Factories(self._project)
        self._types = KnownTypes(self._project)

    @property
    def systems(self) -> Sequence[str]:
        """The systems on the command line."""
        return self._files

    def read(self, file: str) -> System:
        """Return the system of a file or folder; without one, a system without components."""
        if not file:
            return System(
                name="", id="", file="", abstract="", components=(), connections=()
            )
        path = Path(file)
        profile, found, sources = read_file(
            path / "system.xml" if path.is_dir() else path
        )
        found = [*found, *(check_properties(profile) if profile is not None else ())]
        if profile is None or has_errors(found):
            raise InputError(in_order(found))
        self._console.findings(in_order(found), sources)
        return profile

    def write(self, file: str, text: str) -> None:
        """Write a system, below the working folder or beside a system of the command line.

        Only a file that describes a system is overwritten.
        """
        from rtgen.project import is_system
        from rtgen.ui.errors import FILE, CommandError

        path = Path(file)
        if path.is_dir() and file:
            path = path / "system.xml"
        path = path.resolve()
        roots = [Path.cwd(), *(Path(each).resolve().parent for each in self._files)]
        inside = any(path.is_relative_to(root.resolve()) for root in roots)
        if path.suffix.lower() not in _SUFFIXES or not inside:
            raise CommandError(
                FILE,
                f"{file} is not an XML or YAML file of the project",
                f"a name that ends in {', '.join(_SUFFIXES)}, beside the system",
            )
        if path.exists() and not is_system(path):
            raise CommandError(FILE, f"{file} exists and is not a system")
        part = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            part.write_text(text, encoding="utf-8")
            part.replace(path)
        except OSError as error:
            part.unlink(missing_ok=True)
            raise CommandError(
                FILE, f"cannot write {file}: {error.strerror}"
            ) from error

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[[Failure], None]
    ) -> runtime.System:
        """Return a system with its timeline; nothing is activated before time passes.

        Foreign components and their connections are omitted.
        """
        simulated = isinstance(clock, runtime.SimulatedClock)
        report = FailureReport(self._console, FailureOptions(), simulated=simulated)
        path = Path(profile.file)
        folder = path.parent if path.name == "system.xml" else path
        steps = timeline.of_system(folder, None, profile).steps
        if outside := named(profile, None, self._factories.foreign):
            here = {c.instance for c in profile.components} - outside
            steps = steps_here(steps, profile, here, data=True)
            profile = alone(profile, here)
        system = assemble(
            profile, self._factories, clock, (), steps, self._transport, report=report
        )

        def on_failure(failure: Failure) -> None:
            report(failure)
            failed(failure)

        system.on_failure = on_failure
        return system

    def add(self, system: runtime.System, component: SystemComponent) -> None:
        """Add a component whose type has a factory."""
        report = FailureReport(self._console, FailureOptions())
        add_component(system, component, self._factories, Path.cwd(), report)

    def record(self, system: runtime.System) -> Callable[[], None]:
        """Record a run; each has a file of its own: `FILE.mcap`, `FILE-2.mcap`, ..."""
        self._runs += 1
        options = self._recording
        if options.file is not None and self._runs > 1:
            path = Path(options.file)
            file = path.with_name(f"{path.stem}-{self._runs}{path.suffix}")
            options = replace(options, file=str(file))
        files = ExitStack()
        recorder = options.begin(files, system)

        def end() -> None:
            if recorder is not None:
                recorder.end(through=True)
            options.tell(self._console, recorder)
            files.close()

        return end

    def describer(self, bus: str, network: str) -> BusDescriber:
        """Return the description of a bus.

        That is the file for its channel, else the default one, else the one of its network in the
        project.
        """
        from rtgen.cli.ui_bus import BusDescriber

        named = self._buses.get(bus, self._buses.get(""))
        if named is None and network:
            for path in filter(is_bus_file, self._project.sources):
                try:
                    found = BusDescriber(path)
                except InputError:
                    continue  # `rtgen lint` reports its errors
                if found.network == network:
                    return found
        return BusDescriber(named)

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type declared by the project or by OpenRTM."""
        return self._types.data_type(name)

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface declared by the project."""
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
        """Return the types whose factories are importable classes."""
        found = []
        for name in sorted(self._factories.types):
            try:
                profile = getattr(self._factories[name], "profile", None)
            except (FactoryImportError, ToolError):
                continue  # `rtgen run` reports it if a system needs the type.
            if isinstance(profile, ComponentProfile):
                found.append(msgspec.structs.replace(profile, type_name=name))
        return found


def _session(
    project: CommandProject,
    clock: Callable[[], runtime.Clock],
    name_servers: tuple[str, ...],
    transport: CorbaTransport | None,
    recording: str,
) -> Session:
    """Return the session of the first system. Raises InputError, ToolError."""
    from rtgen.ui.session import Session

    file = next(iter(project.systems), "")
    own = None if transport is None else transport.rt_objects
    try:
        return Session(project, file, clock, name_servers, own, recording)
    except runtime.TransportError as error:
        raise ToolError(str(error)) from error


def _opened(name_server: str, closing: ExitStack) -> CorbaTransport:
    """Open the transport of a system whose components are found by a naming service.

    Raises ToolError.
    """
    from rtgen.runtime.corba.transport import CorbaTransport

    try:
        return closing.enter_context(CorbaTransport(name_server=name_server))
    except runtime.TransportError as error:
        raise ToolError(str(error), hint="start omniNames there") from error


@click.command()
@click.argument("systems", metavar="[SYSTEM]...", nargs=-1)
@click.option(
    "--clock",
    type=click.Choice(["sim", "real"]),
    default="sim",
    show_default=True,
    help="Simulated time, which can be paused and stepped, or real time.",
)
@click.option(
    "--port",
    type=WholeRange(0, 65535),
    default=0,
    help="Port on 127.0.0.1, where pages reconnect after a restart; default: any free port.",
)
@click.option(
    "--bus",
    "buses",
    multiple=True,
    metavar="[CHANNEL=]FILE",
    help="The bus file (TOML) that describes the nodes of a CAN bus.",
)
@click.option(
    "--nameserver",
    "name_servers",
    multiple=True,
    type=Place(),
    metavar="HOST[:PORT]",
    help="Also show the components of a CORBA naming service.",
)
@click.option(
    "--transport",
    type=click.Choice(["direct", "corba"]),
    default="direct",
    help="corba: also bind the components of this system in the naming service (real time).",
)
@with_recording
@click.option("--read-only", is_flag=True, help="Also print a read-only address.")
@click.option("--open/--no-open", "opened", default=True, help="Open a browser.")
@click.option(
    "--play/--pause",
    "playing",
    default=True,
    help="Start the run at once.",
)
@with_console
def ui(
    console: Console,
    systems: tuple[str, ...],
    clock: str,
    port: int,
    buses: tuple[str, ...],
    name_servers: tuple[str, ...],
    transport: str,
    recording: RecordingOptions,
    read_only: bool,
    opened: bool,
    playing: bool,
) -> int:
    """Show a system in a browser: wire it, drive it, watch it.

    SYSTEM is an RtsProfile, or a folder with system.xml. The page shows the first one and can open
    the others. Instead of systems, one recording (FILE.mcap) is shown, or two are compared. A
    recording given with systems is compared with the running one. With --nameserver, SYSTEM is
    optional. The page is served at 127.0.0.1 only; its address contains a secret token.
    """
    if not systems and not name_servers:
        raise click.UsageError(
            "Missing argument 'SYSTEM...', or option '--nameserver'."
        )
    missing = [
        name
        for name in ("starlette", "uvicorn", "websockets")
        if find_spec(name) is None
    ]
    if missing:
        raise ToolError(
            f"not installed: {', '.join(missing)}; rtgen ui needs them",
            hint="pip install 'rtgen[ui]'",
        )
    from rtgen.cli.ui_bus import BusDescriber
    from rtgen.cli.ui_tokens import tokens_of
    from rtgen.project.rules import NO_PAGE
    from rtgen.ui.recorded import Recorded
    from rtgen.ui.server import PAGE
    from rtgen.ui.serving import Server

    if not (PAGE / "index.html").is_file():
        message = "this installation of rtgen has no page to show in a browser"
        hint = "run `make page` in the checkout of rtgen, then install rtgen again"
        console.findings([NO_PAGE.at(None, message, hint=hint)])
    clocks = {"sim": runtime.SimulatedClock, "real": runtime.RealClock}
    described = {}
    for each in buses:
        channel, _, file = each.rpartition("=")
        described[channel] = Path(file)
    for path in described.values():
        BusDescriber(path)  # raises InputError before anything runs
    if name_servers and find_spec("omniORB") is None:
        raise ToolError(
            "--nameserver needs omniORBpy, which is not installed",
            hint="pip install 'rtgen[corba]'",
        )
    recordings = [each for each in systems if Path(each).suffix.lower() == ".mcap"]
    session: Session | Recorded
    closing = ExitStack()
    tokens = tokens_of(port) if port else None
    others = [each for each in systems if each not in recordings]
    if recordings and (len(recordings) > (1 if others else 2)):
        raise Refusal(
            "a recording can be compared with one system or one other recording"
        )
    if recordings and not others:
        if name_servers or recording.file is not None:
            raise Refusal(
                "a recording is shown without --nameserver and --record: no system runs"
            )
        project = CommandProject(console, [], described)
        session = Recorded(recordings, project.describer, project.codec)
        if session.left_out:
            console.say(
                f"the recording is too large: shown from {session.history.first:.3f} s on"
            )
        server = Server(session, _LOOPBACK, port, tokens=tokens)
    else:
        kind = clock if others else "real"
        carrier = None
        if transport == "corba":
            if not name_servers or kind != "real" or len(others) > 1:
                raise Refusal(
                    "--transport corba needs --nameserver, --clock real and one system"
                )
            carrier = _opened(name_servers[0], closing)
        project = CommandProject(console, others, described, carrier, recording)
        beside = next(iter(recordings), "")
        session = _session(project, clocks[kind], name_servers, carrier, beside)
        server = Server(session, _LOOPBACK, port, tokens=tokens)
        if playing:
            session.runner.submit(session.runner.play)

    def ready() -> None:
        write_out(f"{server.address(full=True)}\n")
        if read_only:
            write_out(f"read-only: {server.address(full=False)}\n")
        if opened:
            webbrowser.open(server.address(full=True))

    # uvicorn raises a signal again after it has ended: the run must end in order, too.
    with closing, terminable():
        asyncio.run(server.run(ready))
    return OK
