"""The command group `rtgen new`: starts a project, and parts of one."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS = {
    "project": "Create a folder with a component, a system, and their tests.",
    "component": "Add a component with its behaviour and test.",
    "device": "Add a CANopen device with a bus, its behaviour and test.",
    "board": "Add a TECS board with a join and a test.",
    "base": "Create a folder with a mobile base for ROS 2, from its drives.",
    "system": "Add a system of components, connected by their types, and a test.",
    "ros2-package": "Add packages for colcon: interfaces, systems with launch files.",
    "template": "Copy a template of generated files into the project, or list them.",
    "backend": "Create a package that extends rtgen by a back end.",
}
"""Commands with their help lines; the module `commands` has a function for each."""


@click.group(
    cls=LazyGroup,
    summaries=COMMANDS,
    target="rtgen.cli.new.commands:{0}",
    elsewhere={"ros2-package": "rtgen.cli.new.ros2_package:ros2_package"},
)
def new() -> None:
    """Create a project, or add a part to the project around the working folder.

    The new files pass rtgen check, rtgen lint, mypy --strict and their own test. Nothing is
    overwritten: if a file exists, or the result would have errors, no file is created.
    """
