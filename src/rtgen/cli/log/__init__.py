"""`rtgen log`: recordings and logs of runs."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS: dict[str, str] = {
    "info": "Show the contents of a file.",
    "cat": "Print the events of a file as JSON lines.",
    "play": "Print the events of a file, each at its time.",
    "csv": "Write values of ports as CSV.",
    "plot": "Plot values of ports over time.",
    "diff": "Compare two files.",
    "export": "Write a bag of ROS 2.",
}
"""Command to its line of help; the module `<command>_command` has a function `<command>_`."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.log.{0}_command:{0}_")
def log() -> None:
    """Show, export and compare recorded runs.

    FILE is a file that `rtgen run` wrote: MCAP by --record, or JSON lines by --log; or a bag of
    ROS 2: a folder, or a file in MCAP or sqlite3.
    """
