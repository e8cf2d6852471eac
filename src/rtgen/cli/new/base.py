"""The command `rtgen new base`, and what all commands of the group end with."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.project import Project, shown
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, OK


@command()
@click.argument("name", metavar="NAME")
@click.argument(
    "drives",
    nargs=-1,
    required=True,
    metavar="EDS...|CDL",
    type=click.Path(path_type=Path),
)
@click.option("--ros2", "is_ros2", is_flag=True, help="Serve it as a node of ROS 2.")
@click.option("--twist", is_flag=True, help="/cmd_vel is a Twist, not a TwistStamped.")
@with_console
def base(
    console: Console, name: str, drives: tuple[Path, ...], is_ros2: bool, twist: bool
) -> int:
    """Create the folder NAME with a mobile base of two CANopen drives, or of a TECS board.

    EDS are the descriptions of the left and the right drive, or one for both: drives of CiA 402
    whose PDOs have controlword, mode, target velocity, statusword and position. CDL joins a
    signature through RTCPlugin; one of its functions takes the speeds of both wheels, and returns
    the counts of their encoders, or another one does. The base serves /cmd_vel, /odom, /tf,
    /joint_states and /diagnostics; its README says how to drive it, also in a simulation.
    """
    from rtgen.tools.scaffold import bases

    if not is_ros2:
        raise click.UsageError("Missing option '--ros2': all bases are for ROS 2.")
    if len(drives) > len(bases.SIDES):
        raise click.UsageError(
            "EDS: one description, or the left one and the right one."
        )
    target = bases.create(
        name, drives, lambda p: generate(console, p), stamped=not twist
    )
    console.say(f"{shown(target)}: created; see {shown(target / 'README.md')}")
    return OK


def generate(console: Console, project: Project) -> None:
    """Generate what belongs to the new files. Raises ReportedError if there are errors."""
    from rtgen.compiler.project import output
    from rtgen.tools.compiling.cached import build
    from rtgen.tools.kit.exits import ReportedError

    run = build(project, None)
    console.findings(run.diagnostics, run.sources)
    if run.failed:
        raise ReportedError(BAD_INPUT)
    output.write(project, run)
