"""`rtgen can`: CAN buses from the command line."""

from __future__ import annotations

import click

from rtgen.cli.groups import LazyGroup

COMMANDS: dict[str, str] = {
    "monitor": "Decode and show the frames of a bus.",
    "record": "Record the frames of a bus to a file.",
    "replay": "Send the frames of a recording, or decode and print them.",
    "plot": "Plot values of objects over time.",
    "send": "Send frames once, periodically, or from a file.",
    "scan": "Find the nodes of a bus.",
    "sdo": "Read or write an object of a node.",
    "timing": "Calculate the load of a bus and worst-case response times.",
    "hub": "Run a CAN bus for the processes of this machine.",
}
"""Command to its line of help; the module `<command>_command` has a function `<command>_`."""


@click.group(cls=LazyGroup, summaries=COMMANDS, target="rtgen.cli.can.{0}_command:{0}_")
def can() -> None:
    """Monitor CAN buses, access their nodes, or run a bus.

    Buses are python-can's: --interface and --channel name one, as for components.
    """
