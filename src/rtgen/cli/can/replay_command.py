"""The command `rtgen can replay`: sends the frames of a log, or prints them decoded."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtgen.cli.can.options import with_bus, with_nodes
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange
from rtgen.runtime.canopen.bus.messages import frame_of
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.common import counted
from rtgen.tools.can.decoding.frame_printing import Printer, Wanted
from rtgen.tools.can.live.live_bus import (
    can_carry,
    drained,
    opened,
    send,
    until_interrupted,
)
from rtgen.tools.can.parsing import logs
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK

if TYPE_CHECKING:
    from can import Message


@command("replay")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--speed",
    type=FiniteRange(min=0, min_open=True),
    default=1.0,
    show_default=True,
    metavar="FACTOR",
    help="Speed factor.",
)
@click.option("--at-once", is_flag=True, help="Send without pauses.")
@click.option("--decode", is_flag=True, help="Decode and print the frames; use no bus.")
@click.option(
    "--json", "as_json", is_flag=True, help="With --decode: print lines of JSON."
)
@click.option(
    "--node",
    "nodes",
    multiple=True,
    metavar="NODE",
    help="With --decode: only this node.",
)
@click.option(
    "--kind",
    "kinds",
    multiple=True,
    metavar="KIND",
    help="With --decode: only this kind.",
)
@with_nodes
@with_bus
@with_console
def replay_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    file: Path,
    speed: float,
    at_once: bool,
    decode: bool,
    as_json: bool,
    nodes: tuple[str, ...],
    kinds: tuple[str, ...],
) -> int:
    """Send the frames of a recording to a bus, or decode and print them.

    FILE is a recording: .log (candump's log or screen output), .asc or .blf (Vector), .trc (PEAK).
    --decode prints frames as `monitor` does. Error frames and frames of CAN FD are not sent, nor
    are remote frames over socketcand. What is damaged in FILE is reported, and the rest is read.
    """
    node_index = node_files.read(console)
    if decode:
        selection = Wanted(node_index, nodes, kinds)
        printer = Printer(node_index, selection, as_json=as_json, write=write_out)
        for message in logs.read(file, console.say):
            printer.take(message)
        return OK
    if as_json or nodes or kinds:
        raise click.UsageError("--json, --node and --kind go with --decode")
    messages = logs.read(file, console.say, only_certain=True)
    sent = left_out = 0
    with opened(access.on(node_index)) as bus, drained(bus), until_interrupted():
        for message in _in_time(messages, speed, at_once=at_once):
            frame = frame_of(message)
            if frame is None or not can_carry(bus, frame):
                left_out += 1
            else:
                send(bus, frame)
                sent += 1
    missing = f"; {left_out} cannot be sent" if left_out else ""
    console.say(f"{counted(sent, 'frame')} of {file} sent{missing}")
    return OK


def _in_time(
    messages: Iterator[Message], speed: float, *, at_once: bool
) -> Iterator[Message]:
    """Return the messages, each yielded when it is due."""
    from can import MessageSync

    if at_once:
        return messages
    return iter(MessageSync(_faster(messages, speed), gap=0.0, skip=0.0))


def _faster(messages: Iterator[Message], speed: float) -> Iterator[Message]:
    """Divide the times between frames by `speed`; where the clock was set back, there is none."""
    moment = before = 0.0
    for message in messages:
        moment += max(message.timestamp - (before or message.timestamp), 0.0) / speed
        before = message.timestamp
        copied = copy.copy(message)
        copied.timestamp = moment
        yield copied
