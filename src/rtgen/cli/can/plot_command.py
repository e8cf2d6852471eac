"""The command `rtgen can plot`: draws values of objects over time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtgen.cli.can.options import with_bus, with_nodes, with_span
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.decoding.frame_printing import MessageDecoder
from rtgen.tools.can.decoding.node_index import NodeIndex
from rtgen.tools.can.decoding.time_series import check_output, draw, write_csv
from rtgen.tools.can.live.live_bus import frames, opened
from rtgen.tools.can.parsing import logs
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.curve import Curve
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.kit.files import require_different, values_file

if TYPE_CHECKING:
    from can import Message


@command("plot")
@click.argument("objects", nargs=-1, required=True, metavar="OBJECT...")
@click.option(
    "--from",
    "record",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Read values from a recording; default: from the bus.",
)
@click.option(
    "-o",
    "outputs",
    multiple=True,
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Output file: .svg, .png, .pdf or .csv; may be repeated; default: "
    "build/NAME/values.svg.",
)
@with_span
@with_nodes
@with_bus
@with_console
def plot_(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    objects: tuple[str, ...],
    record: Path | None,
    outputs: tuple[Path, ...],
    seconds: float | None,
    count: int | None,
) -> int:
    """Plot values of objects over time, from a recording or a bus.

    OBJECT is NODE.NAME or NODE.6401:1; without NODE, it selects the object of every node that has
    it. Values come from PDOs and SDO, and are physical if the object has a factor. On a bus, the
    command stops at Ctrl-C, or according to --for and --count. Exit code 1: there was no value.
    """
    node_index = node_files.read(console)
    for path in outputs or (Path("values.svg"),):
        check_output(path)
        require_different({"-o": str(path)}, *filter(None, (record,)))
    curves = _series(node_index, objects)
    decoder = MessageDecoder(node_index)
    if record is not None:
        _collect(logs.read(record, console.say), decoder, curves)
    else:
        with (
            opened(access.on(node_index)) as bus,
            frames(bus, seconds, count) as received,
        ):
            _collect(received, decoder, curves)
    if not outputs:
        outputs = (values_file("can" if record is None else record.stem, ".svg"),)
        console.say(f"results: {outputs[0]}")
    for path in outputs:
        if path.suffix.lower() == ".csv":
            write_csv(path, list(curves.values()))
        else:
            draw(path, list(curves.values()))
    for curve in curves.values():
        values = "value" if len(curve.times) == 1 else "values"
        console.say(f"{curve.name}: {len(curve.times)} {values}")
    return OK if any(curve.times for curve in curves.values()) else NO


def _series(
    node_index: NodeIndex, objects: tuple[str, ...]
) -> dict[tuple[str, tuple[int, int]], Curve]:
    series = {}
    for text in objects:
        for node, thing in node_index.find(text):
            key = node.name, thing.number
            series[key] = Curve(f"{node.name}.{thing.name}", thing.unit)
    return series


def _collect(
    received: Iterator[Message | None],
    decoder: MessageDecoder,
    curves: dict[tuple[str, tuple[int, int]], Curve],
) -> None:
    start = None
    for message in received:
        if message is None:
            continue
        start = message.timestamp if start is None else start
        decoded = decoder.decode(message)
        for field in (*decoded.fields, *decoded.taken):
            series = curves.get((field.node, field.thing.number))
            value = field.physical
            if series is not None and isinstance(value, (int, float)):
                series.add(message.timestamp - start, +value)
