"""The command `rtgen can monitor`: shows the decoded frames of a bus."""

from __future__ import annotations

import sys

import click

from rtgen.cli.can.options import with_bus, with_nodes, with_span
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.decoding.frame_printing import MessageDecoder, Printer, Wanted
from rtgen.tools.can.live.live_bus import frames, opened
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK


@command("monitor")
@click.option(
    "--plain", is_flag=True, help="Print a line per frame instead of a table."
)
@click.option("--json", "as_json", is_flag=True, help="Print a line of JSON per frame.")
@click.option(
    "--node", "nodes", multiple=True, metavar="NODE", help="Show only this node."
)
@click.option(
    "--kind",
    "kinds",
    multiple=True,
    metavar="KIND",
    help="Show only this kind: nmt, heartbeat, emcy, sync, time, sdo, tpdo, rpdo1, ...",
)
@with_span
@with_nodes
@with_bus
@with_console
def monitor_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    seconds: float | None,
    count: int | None,
    plain: bool,
    as_json: bool,
    nodes: tuple[str, ...],
    kinds: tuple[str, ...],
) -> int:
    """Decode and show the frames of a bus, with values, names and units.

    On a terminal, the output is a table with a row per identifier; elsewhere, or with --plain, a
    line per frame. The command stops at Ctrl-C, or according to --for and --count.
    """
    node_index = node_files.read(console)
    selection = Wanted(node_index, nodes, kinds)
    with opened(access.on(node_index)) as bus, frames(bus, seconds, count) as received:
        if as_json or plain or not sys.stdout.isatty():
            printer = Printer(node_index, selection, as_json=as_json, write=write_out)
            for message in received:
                if message is not None:
                    printer.take(message)
        else:
            from rtgen.tools.can.decoding.live_table import show

            show(received, MessageDecoder(node_index), selection, bus.bus.channel_info)
    if received.lost:
        console.say(f"{received.lost} frames came too fast and are missing")
    return OK
