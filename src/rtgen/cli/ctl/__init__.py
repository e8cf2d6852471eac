"""The command group `rtgen ctl`: running components of other processes."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS = {
    "list": "List the components of all processes with their states.",
    "show": "Show a component: state, ports, services, parameters.",
    "activate": "Activate components.",
    "deactivate": "Deactivate components.",
    "reset": "Reset components that are in ERROR.",
    "get": "Print the values of parameters.",
    "set": "Set parameters.",
    "use": "Activate a configuration set.",
    "call": "Call an operation of a service.",
    "watch": "Print changes of state.",
}
"""Commands with their help lines; a module has a function `<command>_` for each."""
_OF_PARAMETERS = ("get", "set", "use")


@click.group(
    cls=LazyGroup,
    summaries=COMMANDS,
    target="rtgen.cli.ctl.commands:{0}_",
    elsewhere=dict.fromkeys(_OF_PARAMETERS, "rtgen.cli.ctl.parameter_commands:{0}_")
    | {"call": "rtgen.cli.ctl.call_command:{0}_"},
)
def ctl() -> None:
    """Watch and control components in other processes, over DDS or Zenoh.

    The processes run with --transport dds or zenoh; --system FILE or --partition NAME selects
    their system. Exit codes: 1 a component refuses or ends in ERROR, 3 no process has it.
    """
