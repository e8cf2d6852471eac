"""The command `rtgen can send`: sends frames or a sequence of frames."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from pathlib import Path

import click

from rtgen.cli.can.options import with_bus, with_nodes
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.runtime.canopen.bus.python_can import OpenBus
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.common import counted
from rtgen.tools.can.live.live_bus import drained, opened, send, until_interrupted
from rtgen.tools.can.parsing.frames import FORMS, frame_of_text
from rtgen.tools.can.parsing.sequences import Step, read_sequence
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK


@command("send")
@click.argument("texts", nargs=-1, metavar="[FRAME]...")
@click.option(
    "--file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Send the frames in a file.",
)
@click.option(
    "--every",
    type=FiniteRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Repeat at this interval, until --count or Ctrl-C.",
)
@click.option(
    "--count",
    type=WholeRange(min=1),
    metavar="N",
    help="Number of times to send; default: 1, with --every unlimited.",
)
@with_nodes
@with_bus
@with_console
def send_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    texts: tuple[str, ...],
    file: Path | None,
    every: float | None,
    count: int | None,
) -> int:
    """Send frames once, periodically, or from a file.

    A FRAME is ID#HEX or ID#R with 3 or 8 hexadecimal digits of identifier; sync; 'nmt COMMAND NODE'
    (start, stop, pre-operational, reset-node, reset-communication; a node or all); or, for nodes
    with a description, 'NODE.rpdoN OBJECT=VALUE ...' with physical values, others 0.

    Lines of a file are [TIME] FRAME: TIME is in seconds since the start, or with + since the
    previous line; # starts a comment.
    """
    if bool(texts) == (file is not None):
        raise click.UsageError(f"give frames, or --file; a frame is {FORMS}")
    node_index = node_files.read(console)
    if file is not None:
        steps = read_sequence(file, node_index)
    else:
        steps = [Step(0.0, frame_of_text(text, node_index)) for text in texts]
    sent = 0
    period = steps[-1].at if every is None else every
    times = count or (1 if every is None else None)
    with opened(access.on(node_index)) as bus, drained(bus), until_interrupted():
        begin = time.monotonic()
        for number in itertools.count() if times is None else range(times):
            _run(bus, steps, begin + number * period)
            sent += len(steps)
    console.say(f"{counted(sent, 'frame')} sent")
    return OK


def _run(bus: OpenBus, steps: Sequence[Step], start: float) -> None:
    """Send each frame when it is due."""
    for step in steps:
        pause = start + step.at - time.monotonic()
        if pause > 0:
            time.sleep(pause)
        send(bus, step.frame)
