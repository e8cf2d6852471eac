"""`rtgen log`: recordings and logs of runs."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS: dict[str, str] = {
    "info": "Tell what is in a file.",
    "cat": "Print its events as JSON lines.",
    "csv": "Write values of ports over time.",
    "plot": "Draw values of ports over time.",
    "diff": "Compare two files.",
}
"""Command to its line of help; the module `<command>_command` has a function `<command>_`."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.log.{0}_command:{0}_")
def log() -> None:
    """Look at recorded runs.

    FILE is what `rtgen run` writes: MCAP by --record, or JSON lines by --log.
    """
