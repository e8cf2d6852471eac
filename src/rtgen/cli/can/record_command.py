"""The command `rtgen can record`: writes the frames of a bus to a log."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.can.options import with_bus, with_nodes, with_span
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.live.live_bus import frames, opened
from rtgen.tools.can.parsing.logs import check_kind, writer
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK


@command("record")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@with_span
@with_nodes
@with_bus
@with_console
def record_(
    console: Console,
    node_files: NodeFiles,
    access: BusAccess,
    file: Path,
    seconds: float | None,
    count: int | None,
) -> int:
    """Record every frame of a bus with its time to FILE.

    The suffix selects the format: .log (candump), .asc or .blf (Vector). The command stops at
    Ctrl-C, or according to --for and --count; the file is then complete.
    """
    check_kind(file)
    node_index = node_files.read(console, names=False)
    total = 0
    with (
        opened(access.on(node_index)) as bus,
        writer(file) as record,
        frames(bus, seconds, count) as received,
    ):
        console.say(f"recording {bus.bus.channel_info} to {file}")
        for message in received:
            if message is not None:
                record(message)
                total += 1
    console.say(f"{total} frame{'s' * (total != 1)} in {file}")
    if received.lost:
        console.say(f"{received.lost} frames came too fast and are missing")
    return OK
