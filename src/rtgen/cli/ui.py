"""The command `rtgen ui`: runs a system and shows it in a browser."""

from __future__ import annotations

import webbrowser
from typing import TYPE_CHECKING, Any

import click

from rtgen.cli.help import command, grouped
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import Place, WholeRange
from rtgen.cli.run_table import GIVEN, with_run_table
from rtgen.cli.running_options import with_clock, with_recording, with_value_checks
from rtgen.cli.transport_options import ENGINE_OPTIONS, PROCESSES
from rtgen.tools.kit.console import Console, write_out, write_text
from rtgen.tools.kit.exits import OK
from rtgen.tools.running.engines import TAKES, EngineOptions
from rtgen.tools.running.recording_options import RecordingOptions

if TYPE_CHECKING:
    from rtgen.ui.serving import Server

_OF_RUNS = {
    "clock": "--clock",
    "check_values": "--check-values",
    "name_servers": "--nameserver",
    "transport": "--transport",
    "playing": "--play/--pause",
}
"""The options that need a run, by parameter."""


@command()
@with_console
@with_run_table(system="systems", clock="clock")
@click.argument("systems", metavar="[SYSTEM]...", nargs=-1)
@with_clock
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
    "--attach",
    "attached",
    is_flag=False,
    flag_value="",
    metavar="[NAME|PID]",
    help="Show a running `rtgen run` of this machine, by the name of its system or its process.",
)
@click.option(
    "--nameserver",
    "name_servers",
    multiple=True,
    type=Place(),
    metavar="HOST[:PORT]",
    help="Also show the components of a CORBA naming service.",
)
@grouped(
    PROCESSES,
    click.option(
        "--transport",
        type=click.Choice(["direct", "corba", *TAKES]),
        default="direct",
        help="corba: also bind the components in the naming service (real time); "
        "dds, zenoh: watch the processes that run the system.",
    ),
    *ENGINE_OPTIONS,
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
def ui(
    console: Console,
    systems: str | tuple[str, ...],
    clock: str,
    port: int,
    buses: tuple[str, ...],
    attached: str | None,
    name_servers: tuple[str, ...],
    check_values: str,
    recording: RecordingOptions,
    read_only: bool,
    opened: bool,
    playing: bool,
    **engine: Any,
) -> int:
    """Show a system in a browser: wire it, drive it, watch it.

    SYSTEM is an RtsProfile, or a folder with system.xml; default: that of `[run]`. The page shows
    the first one and can open the others. Instead of systems, one recording (FILE.mcap) is shown,
    or two are compared. A recording given with systems is compared with the running one. With
    --nameserver, SYSTEM is optional. With --transport dds or zenoh, the page shows the processes
    that `rtgen run` has started with the same transport; with --attach, one run of this machine,
    whatever its transport. The page is served at 127.0.0.1 only; its address contains a secret
    token.
    """
    if attached is not None and attached.endswith(".mcap"):  # --attach without a name
        systems, attached = (attached, *systems), ""
    elsewhere = name_servers or engine["partition"] or attached is not None
    if isinstance(systems, str):  # that of `[run]`
        systems = () if elsewhere else (systems,)
    if not systems and not elsewhere:
        raise click.UsageError(
            "Missing argument 'SYSTEM...', or option '--nameserver'. "
            "`[run] system` in rtgen.toml names a system, too."
        )
    from rtgen.ui.launch import UiOptions, served

    context = click.get_current_context()
    options = UiOptions(
        systems=systems,
        simulated=clock == "sim",
        port=port,
        buses=buses,
        name_servers=name_servers,
        engine=EngineOptions(**engine),
        check_values=check_values,
        recording=recording,
        playing=playing,
        attached=attached,
        of_runs=tuple(
            option
            for name, option in _OF_RUNS.items()
            if context.get_parameter_source(name) in GIVEN
        ),
    )

    def ready(server: Server) -> None:
        write_out(f"{server.address(full=True)}\n")
        if read_only:
            write_text(f"read-only: {server.address(full=False)}\n")
        if opened:
            webbrowser.open(server.address(full=True))

    served(options, console, ready)
    return OK
