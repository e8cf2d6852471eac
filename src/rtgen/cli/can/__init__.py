"""`rtgen can`: CAN buses from the command line."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS: dict[str, str] = {
    "monitor": "Show the frames of a bus in words.",
    "record": "Write the frames of a bus to a file.",
    "replay": "Send the frames of a record, or print them in words.",
    "plot": "Draw values of objects over time.",
    "send": "Send frames once, again and again, or as a file says.",
    "scan": "Find the nodes of a bus.",
    "sdo": "Read or write an object of a node.",
    "timing": "Tell the load of a bus, and how late its messages can be.",
    "hub": "Run a CAN bus for the processes of this machine.",
}
"""Command to its line of help; the module `<command>_command` has a function `<command>_`."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.can.{0}_command:{0}_")
def can() -> None:
    """Look at CAN buses, take part in them, or make one.

    Buses are python-can's: --interface and --channel name one, as for components.
    """
