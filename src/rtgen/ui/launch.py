"""Starts the server of `rtgen ui`: a session of systems, or of recordings, and its page."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rtgen import runtime
from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.project_rules import NO_PAGE
from rtgen.facts.extras import installation
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.kit.signals import terminable
from rtgen.tools.running.engines import TAKES, EngineOptions
from rtgen.tools.running.recording_options import (
    MAX_CHUNK_NS,
    RecordingOptions,
    tell_missing,
)
from rtgen.ui.bus_description import BusDescriber
from rtgen.ui.project_systems import CommandProject

if TYPE_CHECKING:
    from rtgen.runtime.corba.transport import NamedCorba
    from rtgen.ui.peers_recorder import PeersRecorder
    from rtgen.ui.peers_watcher import Link
    from rtgen.ui.recorded import Recorded
    from rtgen.ui.remote_state import RemoteState
    from rtgen.ui.serving import Server
    from rtgen.ui.session import Session

_LOOPBACK = "127.0.0.1"
_LIBRARIES = ("starlette", "uvicorn", "websockets")


@dataclass(frozen=True, slots=True, kw_only=True)
class UiOptions:
    """The options of `rtgen ui`, as its help describes them; port 0 is any free one."""

    systems: tuple[str, ...]
    simulated: bool
    port: int
    buses: tuple[str, ...]
    name_servers: tuple[str, ...]
    engine: EngineOptions
    check_values: str
    recording: RecordingOptions
    playing: bool
    attached: str | None = None
    """The name or the process of the run to attach to, empty for the only one; None: to none."""
    of_runs: tuple[str, ...] = ()
    """The options that were given and need a run."""

    @property
    def recordings(self) -> list[str]:
        """The recordings among the systems."""
        return [each for each in self.systems if Path(each).suffix.lower() == ".mcap"]

    @property
    def own_systems(self) -> list[str]:
        """Those that are no recordings."""
        return [each for each in self.systems if each not in self.recordings]


def served(
    options: UiOptions, console: Console, ready: Callable[[Server], None]
) -> None:
    """Serve until a signal; `ready` is called when pages can connect.

    Raises InputError, Refusal, ToolError.
    """
    _require_libraries(options, console)
    options.engine.check_taken(TAKES)
    from rtgen.ui.arrangements import of_user
    from rtgen.ui.serving import Server
    from rtgen.ui.stored_tokens import tokens_of

    buses: dict[str, Path] = {}
    for each in options.buses:
        channel, _, file = each.rpartition("=")
        buses[channel] = Path(file)
    for path in buses.values():
        BusDescriber(path)  # raises InputError before anything runs
    closing = ExitStack()
    server_of = partial(
        Server,
        host=_LOOPBACK,
        port=options.port,
        tokens=tokens_of(options.port) if options.port else None,
        arrangements=of_user(),
    )
    is_attached = options.attached is not None
    only_recordings = len(options.recordings) == len(options.systems) > 0
    if only_recordings and not is_attached:
        session: Session | Recorded = _recorded(options, console, buses)
        server = server_of(session)
    else:
        if is_attached:
            session = _attached(options, console, buses)
        elif options.engine.transport in TAKES:
            session = _joined(options, console, buses, closing)
        else:
            session = _running(options, console, buses, closing)
        server = server_of(session)
        if options.playing:
            session.runner.submit(session.runner.play)
    # uvicorn raises a signal again after it has ended: the run must end in order, too.
    with closing, terminable():
        asyncio.run(server.run(partial(ready, server)))


def _require_libraries(options: UiOptions, console: Console) -> None:
    missing = [name for name in _LIBRARIES if find_spec(name) is None]
    if missing:
        raise ToolError(
            f"not installed: {', '.join(missing)}; rtgen ui needs them",
            hint=installation("ui"),
        )
    from rtgen.ui.server import PAGE

    if not (PAGE / "index.html").is_file():
        message = "this installation of rtgen has no page to show in a browser"
        hint = "run `make page` in the checkout of rtgen, then install rtgen again"
        console.findings([NO_PAGE.at(None, message, hint=hint)])
    if options.name_servers and find_spec("omniORB") is None:
        raise ToolError(
            "--nameserver needs omniORBpy, which is not installed",
            hint=installation("corba"),
        )


def _recorded(
    options: UiOptions, console: Console, buses: Mapping[str, Path]
) -> Recorded:
    """Return the session of one recording, or two that are compared."""
    from rtgen.ui.recorded import Recorded

    _check_number(options, 2)
    needless = [*options.of_runs, *["--record"] * (options.recording.file is not None)]
    if needless:
        raise Refusal(
            f"a recording is shown without {', '.join(needless)}: no system runs"
        )
    project = CommandProject(console, [], dict(buses))
    session = Recorded(options.recordings, project.describer, project.codec)
    if session.left_out:
        console.say(
            f"the recording is too large: shown from {session.history.first:.3f} s on"
        )
    return session


def _running(
    options: UiOptions, console: Console, buses: Mapping[str, Path], closing: ExitStack
) -> Session:
    """Return the session of the first system. Raises InputError, Refusal, ToolError."""
    from rtgen.ui.session import Session

    _check_number(options, 1)
    systems = options.own_systems
    simulated = options.simulated and bool(systems)
    transport = None
    if options.engine.transport == "corba":
        if not options.name_servers or simulated or len(systems) > 1:
            raise Refusal(
                "--transport corba needs --nameserver, --clock real and one system"
            )
        transport = _corba(options.name_servers[0], closing)
    project = CommandProject(
        console,
        systems,
        dict(buses),
        transport,
        options.recording,
        options.check_values,
    )
    clock = runtime.SimulatedClock if simulated else runtime.RealClock
    own = None if transport is None else transport.rt_objects
    beside = next(iter(options.recordings), "")
    file = next(iter(project.systems), "")
    try:
        return Session(project, file, clock, options.name_servers, own, beside)
    except runtime.TransportError as error:
        raise ToolError(str(error)) from error


def _joined(
    options: UiOptions, console: Console, buses: Mapping[str, Path], closing: ExitStack
) -> Session:
    """Return a session that watches the processes of a system over DDS or Zenoh.

    Raises InputError, Refusal, ToolError.
    """
    from rtgen.ui.attaching import EngineLink
    from rtgen.ui.description import written_connection

    systems = options.own_systems
    if options.name_servers or len(systems) > 1:
        raise Refusal(
            f"--transport {options.engine.transport} shows the run of one system: "
            "without --nameserver"
        )
    project = CommandProject(console, systems, dict(buses))
    # Without a system, that of the partition is shown without its connections.
    profile = project.read(next(iter(systems), "")).profile
    name = options.engine.partition or profile.name
    connections = {each.name: written_connection(each) for each in profile.connections}
    recording = _Recording(options.recording, console)
    closing.callback(recording.tell)
    link = EngineLink(options.engine.open(name), connections)
    place = f"{options.engine.transport} {name}"
    return _watching(options, project, link, place, recording)


class _Recording:
    """The recording of a run over a transport, if there is a file. Raises ToolError."""

    def __init__(self, options: RecordingOptions, console: Console) -> None:
        self._console = console
        self._options = options
        self._files = ExitStack()
        self._recorder: PeersRecorder | None = None
        self._writer = (
            options.writer(self._files, options.file, MAX_CHUNK_NS)
            if options.file
            else None
        )

    def begin(self, report: Callable[[str, str], None]) -> PeersRecorder | None:
        """Begin to record; `report` gets failures, of no component."""
        if self._writer is None:
            return None
        from rtgen.ui.peers_recorder import PeersRecorder

        failed = partial(report, "")
        self._recorder = PeersRecorder(self._writer, self._files, failed)
        return self._recorder

    def tell(self) -> None:
        """Report which file was recorded, and what it lacks."""
        if self._recorder is not None:
            file = self._options.file or ""
            tell_missing(self._console, file, self._recorder.missing)
            self._options.name_file(self._console)


def _attached(
    options: UiOptions, console: Console, buses: Mapping[str, Path]
) -> Session:
    """Return a session that watches a run of this machine.

    Raises InputError, Refusal, ToolError.
    """
    from rtgen.runtime.distribution.medium import MediumError
    from rtgen.ui.attaching import RunLink

    if (
        options.name_servers
        or options.own_systems
        or options.engine.transport != "direct"
    ):
        raise Refusal(
            "--attach shows a run of this machine: without SYSTEM, --transport and "
            "--nameserver"
        )
    path = _chosen_run(options.attached or "", console)
    try:
        link = RunLink(path, recording=options.recording)
    except (OSError, MediumError) as error:
        raise ToolError(str(error)) from error
    hello = link.hello
    files = [hello.file] if Path(hello.file).is_file() else []
    project = CommandProject(console, files, dict(buses))
    return _watching(options, project, link, f"process {hello.pid}")


def _chosen_run(wanted: str, console: Console) -> Path:
    """Return the socket of the run that the user means. Raises ToolError, Refusal."""
    from rtgen.runtime.distribution import local_runs
    from rtgen.ui.attaching import chosen

    if not local_runs.is_supported():
        raise ToolError(
            "--attach works on Linux and macOS: this system has no sockets of one user",
            hint="`--transport zenoh` and `--transport dds` show a run on any system",
        )
    try:
        runs = local_runs.runs()
    except OSError as error:
        raise ToolError(str(error)) from error
    fitting = chosen(runs, wanted)
    listed = [
        f"{hello.pid}: {hello.name}, {hello.command}" for _, hello in fitting or runs
    ]
    if not fitting:
        known = "".join(f"\n  {each}" for each in listed)
        of_others = wanted.isdecimal() and _is_of_another_user(int(wanted))
        raise ToolError(
            (
                f"process {wanted} belongs to another user, who alone can attach to it"
                if of_others
                else f"no run {wanted!r}; these run:{known}" if runs else "nothing runs"
            ),
            hint="`rtgen run SYSTEM` starts a run, of the same user on this machine",
        )
    if len(fitting) == 1:
        return fitting[0][0]
    number = console.choice("several runs:", listed)
    if number is None:
        known = "".join(f"\n  {each}" for each in listed)
        raise Refusal(f"several runs; --attach PID chooses one:{known}")
    return fitting[number][0]


def _is_of_another_user(process: int) -> bool:
    try:
        os.kill(process, 0)
    except PermissionError:
        return True
    except (OSError, OverflowError):
        pass
    return False


def _watching(
    options: UiOptions,
    project: CommandProject,
    link: Link,
    place: str,
    recording: _Recording | None = None,
) -> Session:
    """Return a session that shows what other processes run."""
    from rtgen.ui.peers_watcher import PeersWatcher
    from rtgen.ui.session import Session

    _check_number(options, 1)

    def attach(
        publish: Callable[[RemoteState], bool], report: Callable[[str, str], None]
    ) -> PeersWatcher:
        recorder = None if recording is None else recording.begin(report)
        data_type = project.data_type
        return PeersWatcher(link, place, data_type, publish, report, recorder=recorder)

    beside = next(iter(options.recordings), "")
    return Session(project, "", runtime.RealClock, recording=beside, attach=attach)


def _check_number(options: UiOptions, most: int) -> None:
    if len(options.recordings) > most:
        raise Refusal(
            "a recording can be compared with one system or one other recording"
        )


def _corba(name_server: str, closing: ExitStack) -> NamedCorba:
    """Open the transport of a system whose components are found by a naming service.

    Raises ToolError.
    """
    from rtgen.runtime.corba.transport import NamedCorba

    try:
        return closing.enter_context(NamedCorba(name_server=name_server))
    except runtime.TransportError as error:
        raise ToolError(str(error), hint="start omniNames there") from error
