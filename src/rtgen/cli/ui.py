"""The command `rtgen ui`: runs a system and shows it in a browser."""

from __future__ import annotations

import asyncio
import webbrowser
from collections.abc import Callable
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import click

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
from rtgen.cli.running.recording_options import RecordingOptions, with_recording
from rtgen.cli.running.value_checks import with_value_checks
from rtgen.cli.signals import terminable
from rtgen.cli.ui_project import CommandProject
from rtgen.diagnostics import ToolError

if TYPE_CHECKING:
    from rtgen.runtime.corba.transport import NamedCorba
    from rtgen.ui.session import Session

_LOOPBACK = "127.0.0.1"


def _session(
    project: CommandProject,
    clock: Callable[[], runtime.Clock],
    name_servers: tuple[str, ...],
    transport: NamedCorba | None,
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


def _opened(name_server: str, closing: ExitStack) -> NamedCorba:
    """Open the transport of a system whose components are found by a naming service.

    Raises ToolError.
    """
    from rtgen.runtime.corba.transport import NamedCorba

    try:
        return closing.enter_context(NamedCorba(name_server=name_server))
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
@with_value_checks
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
    check_values: str,
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
        project = CommandProject(
            console, others, described, carrier, recording, check_values
        )
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
