"""The command `rtgen run`: runs a system on the embedded runtime."""

from __future__ import annotations

import click

from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.cli.running_options import (
    with_failures,
    with_live,
    with_recording,
    with_ros2,
    with_value_checks,
)
from rtgen.cli.supervision_options import check_options, handed_on
from rtgen.cli.transport_options import with_transport
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.execution import executed
from rtgen.tools.running.failures import FailureOptions
from rtgen.tools.running.live_options import LiveOptions
from rtgen.tools.running.plan import Plan, RunOptions, planned
from rtgen.tools.running.recording_options import RecordingOptions
from rtgen.tools.running.transports import TransportOptions


@click.command()
@click.argument("system", metavar="SYSTEM")
@click.option(
    "--clock",
    type=click.Choice(["sim", "real"]),
    default="sim",
    show_default=True,
    help="Simulated time, as fast as the machine allows, or real time.",
)
@click.option(
    "--until",
    metavar="SECONDS|INSTANCE=STATE",
    help="End the run at this time or state.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="INSTANCE.PARAMETER=VALUE",
    help="Set a configuration parameter.",
)
@click.option(
    "--timeline",
    "timeline_file",
    metavar="FILE",
    help="Timeline of the run; default: timeline.toml of the folder.",
)
@click.option(
    "--csv",
    "table",
    multiple=True,
    metavar="FILE|INSTANCE.PORT",
    help="Write the trajectory as CSV, or values of ports and observables.",
)
@click.option(
    "--plot",
    "picture",
    multiple=True,
    metavar="FILE|INSTANCE.PORT",
    help="Draw the trajectory (.svg, .png, .pdf), or values of ports and observables.",
)
@click.option(
    "--log", metavar="FILE", help="Write state changes and samples as JSON lines."
)
@click.option(
    "--checkpoints",
    metavar="FOLDER",
    help="Save the declared state of components there, and restore it at the start.",
)
@click.option(
    "--supervise",
    type=click.Choice(["never", "on-failure"]),
    help="Run each component in its own process, with a restart policy.",
)
@click.option(
    "--group",
    "groups",
    multiple=True,
    metavar="INSTANCE,...",
    help="Components that share a process (--supervise).",
)
@click.option(
    "--restarts",
    type=WholeRange(0, 1000000),
    default=5,
    show_default=True,
    metavar="NUMBER",
    help="Maximum number of consecutive restarts of a process (--supervise).",
)
@with_value_checks
@with_recording
@with_ros2
@with_live
@with_transport
@with_failures
@with_console
def run(
    console: Console,
    system: str,
    clock: str,
    until: str | None,
    settings: tuple[str, ...],
    timeline_file: str | None,
    table: tuple[str, ...],
    picture: tuple[str, ...],
    log: str | None,
    checkpoints: str | None,
    supervise: str | None,
    groups: tuple[str, ...],
    restarts: int,
    check_values: str,
    recording: RecordingOptions,
    ros2: str | None,
    live: LiveOptions,
    carrying: TransportOptions,
    shown_failures: FailureOptions,
) -> int:
    """Run a system on the embedded runtime.

    SYSTEM is an RtsProfile, or a folder with system.xml and optionally timeline.toml. Exit code 0:
    the condition of --until, or of the system's property rtgen.run.until, was met; 1: it was not
    met in time, the robot ended beyond rtgen.run.tolerance, a component ended in ERROR (unless
    rtgen.run.finishes names it), or its code raised an exception; 130: Ctrl-C or SIGTERM ended it
    before. A run in simulated time that only waits for a state ends after ten minutes.

    --csv and --plot may be repeated: INSTANCE.PORT, INSTANCE.PORT.member and INSTANCE.PORT[index]
    are values over time, anything else is the output file, by default values.csv and values.svg
    below build. Without values, the file contains the trajectory.

    With --transport corba, service calls use omniORB, and components appear as components of
    OpenRTM; with --transport dds or zenoh, samples and calls use DDS or Zenoh. With --only, this
    process runs a part of the system, and exchanges samples and calls with the processes that run
    the rest.
    """
    options = RunOptions(
        system=system,
        simulated=clock == "sim",
        until=until,
        settings=settings,
        timeline_file=timeline_file,
        table=table,
        picture=picture,
        log=log,
        checkpoints=checkpoints,
        check_values=check_values,
        recording=recording,
        ros2=ros2,
        live=live,
        carrying=carrying,
        shown_failures=shown_failures,
    )
    plan = planned(options, console)
    if supervise is not None:
        return _supervised(plan, console, groups, supervise == "on-failure", restarts)
    if groups:
        raise Refusal("--group needs --supervise")
    return executed(plan.of_this_process(), console)


def _supervised(
    plan: Plan, console: Console, groups: tuple[str, ...], restart: bool, restarts: int
) -> int:
    from rtgen.tools.running import supervision

    context = click.get_current_context()
    check_options(context)
    policy = supervision.Policy(restart, restarts)
    return supervision.supervised(plan, console, groups, policy, handed_on(context))
