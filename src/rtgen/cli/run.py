"""The command `rtgen run`: runs a system on the embedded runtime."""

from __future__ import annotations

from typing import Any

import click

from rtgen.cli.help import command, grouped
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import WholeRange
from rtgen.cli.ros2_options import ROS2_OPTION
from rtgen.cli.run_table import required, with_run_table
from rtgen.cli.running_options import (
    with_clock_of_run,
    with_failures,
    with_live,
    with_recording,
    with_value_checks,
)
from rtgen.cli.supervision_options import check_options, handed_on
from rtgen.cli.transport_options import PROCESSES, with_transport
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.execution import executed
from rtgen.tools.running.plan import BOARDS, Plan, RunOptions, planned


@command()
@with_console
@with_run_table(
    system="system",
    clock="clock",
    until="until",
    transport="transport",
    partition="partition",
    record="recorded",
)
@click.argument("system", metavar="[SYSTEM]", required=False)
@click.option("--told", "is_told", is_flag=True, hidden=True)
@with_clock_of_run
@click.option(
    "--until",
    metavar="CONDITION",
    help="End: SECONDS, INSTANCE=STATE, or both (comma).",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="I.PARAMETER=VALUE",
    help="Set a configuration parameter of instance I.",
)
@click.option(
    "--timeline",
    "timeline_file",
    metavar="FILE",
    help="Timeline; default: timeline.toml of the folder.",
)
@click.option(
    "--checkpoints",
    metavar="FOLDER",
    help="Keep the state of components for the next run.",
)
@click.option(
    "--inactive", is_flag=True, help="Leave the components to those who activate them."
)
@grouped(
    "Results",
    click.option(
        "--csv",
        "table",
        multiple=True,
        metavar="FILE|INSTANCE.PORT",
        help="Write the trajectory, or values, as CSV.",
    ),
    click.option(
        "--plot",
        "picture",
        multiple=True,
        metavar="FILE|INSTANCE.PORT",
        help="Draw them: .svg, .png or .pdf.",
    ),
    click.option(
        "--log", metavar="FILE", help="Write states and samples as JSON lines."
    ),
    click.option(
        "--json",
        "as_json",
        is_flag=True,
        help="Print the report as JSON (rtgen-run/1).",
    ),
)
@with_recording
@with_live
@with_transport
@grouped(PROCESSES, ROS2_OPTION)
@grouped(
    "Supervision",
    click.option(
        "--supervise",
        type=click.Choice(["never", "on-failure"]),
        metavar="RESTART",
        help="One process each; restart: never, on-failure.",
    ),
    click.option(
        "--group",
        "groups",
        multiple=True,
        metavar="INSTANCE,...",
        help="Components that share a process.",
    ),
    click.option(
        "--restarts",
        type=WholeRange(0, 1000000),
        default=5,
        metavar="NUMBER",
        help="In a row; default: 5.",
    ),
)
@with_value_checks
@with_failures
def run(
    console: Console,
    system: str | None,
    clock: str,
    supervise: str | None,
    groups: tuple[str, ...],
    restarts: int,
    ros2: str | None,
    **others: Any,
) -> int:
    """Run a system on the embedded runtime.

    SYSTEM is an RtsProfile, or a folder with system.xml; it and missing options are those of
    `[run]` in rtgen.toml; no system and --ros2: its boards alone. Exit code 1: the end was not
    reached, a component ended in ERROR, or its code raised; 130: interrupted. --csv and --plot may
    be repeated.
    """
    options = RunOptions(
        system=(system or BOARDS) if ros2 is not None else required(system),
        simulated=clock != "real",
        follows_ros=clock == "ros",
        ros2=ros2,
        **others,
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
