"""The command group `rtgen ctl`: running components of other processes."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS = {
    "list": "List the components of all processes with their states.",
    "show": "Show a component: state, ports, services, parameters.",
    "activate": "Make components ACTIVE.",
    "deactivate": "Make components INACTIVE.",
    "reset": "Make components INACTIVE that are in ERROR.",
    "get": "Print the values of parameters.",
    "set": "Set parameters.",
    "use": "Make a configuration set the active one.",
    "watch": "Print changes of state as they happen.",
}
"""Commands with their help lines; the module `commands` has a function `<command>_` for each."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.ctl.commands:{0}_")
def ctl() -> None:
    """Watch and steer components that run elsewhere, over DDS or Zenoh.

    The processes run with --transport dds or zenoh; --system FILE or --partition NAME says which
    system they share. Exit codes: 1 a component refuses or ends in ERROR, 3 nobody has it.
    """
