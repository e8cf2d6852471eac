"""The command group `rtgen new`: starts a project, and parts of one."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS = {
    "project": "Make a folder with a component, a system, and their tests.",
    "component": "Add a component with its behaviour and test.",
    "device": "Add a CANopen device with a bus, its behaviour and test.",
    "board": "Add a TECS board with a join and a test.",
    "system": "Add a system of components, connected by their types, and a test.",
    "backend": "Make a package that extends rtgen by a back end.",
}
"""Commands with their help lines; the module `commands` has a function for each."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.new.commands:{0}")
def new() -> None:
    """Start a project, or add a part to the project around the working folder.

    What is made passes rtgen check, rtgen lint, mypy --strict and its own test at once. Nothing
    is overwritten; where a file exists, or the result would have errors, nothing is made.

    \b
    Example:
      rtgen new project my-robot
      cd my-robot
      rtgen new component Arm
    """
