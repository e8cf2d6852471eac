"""`rtgen can scan --eds NODE`: the options, and the table of the objects of the node."""

from __future__ import annotations

from pathlib import Path

import click
import msgspec

from rtgen.cli.help import gathered
from rtgen.cli.parameter_types import FiniteRange
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import table
from rtgen.tools.can.access import BusAccess, NodeFiles
from rtgen.tools.can.live.bus_session import BusSession
from rtgen.tools.can.live.dictionary_reading import AREAS, Pace
from rtgen.tools.can.live.live_bus import opened
from rtgen.tools.can.live.node_file import NodeFile, read_node, require_new, write_new
from rtgen.tools.kit.console import Console, write_out, write_text
from rtgen.tools.kit.exits import INTERRUPTED, NO, OK, Refusal
from rtgen.tools.kit.signals import terminable

_LONGEST_TIMEOUT = 0.5
"""Seconds to wait for a response at most; `--for` shortens it."""


class NodeFileOptions(msgspec.Struct, frozen=True):
    """How the objects of a node are read, and the file for them."""

    output: Path | None
    ranges: tuple[range, ...]
    limit: float
    rate: float


def _ranges(
    context: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> tuple[range, ...]:
    ranges = []
    for text in values:
        first, _, last = text.partition("-")
        try:
            low, high = int(first, 16), int(last or first, 16)
        except ValueError:
            low, high = 0, 0
        if not 0x1000 <= low <= high <= 0xFFFF:
            message = f"{text!r} is not FROM-TO in hexadecimal, from 1000 to FFFF"
            raise click.BadParameter(message, context, parameter)
        ranges.append(range(low, high + 1))
    return tuple(ranges)


with_node_file = gathered(
    "reading",
    NodeFileOptions,
    click.option(
        "-o",
        "output",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="A new file; default: node_ID.eds.",
    ),
    click.option(
        "--range",
        "ranges",
        multiple=True,
        metavar="FROM-TO",
        callback=_ranges,
        help="Indices to scan, such as 2000-20FF; may be repeated; "
        "default: 1000-1FFF, 2000-5FFF and 6000-9FFF. Known communication objects and "
        "mapped objects are always read.",
    ),
    click.option(
        "--limit",
        type=FiniteRange(min=0, min_open=True),
        default=600.0,
        show_default=True,
        metavar="SECONDS",
        help="Time for all objects; then the file is partial.",
    ),
    click.option(
        "--rate",
        type=FiniteRange(min=1),
        default=1000.0,
        show_default=True,
        metavar="N",
        help="Most requests in a second.",
    ),
    title="Description of a node (--eds NODE)",
)


def node_to_read(node_files: NodeFiles) -> tuple[str | None, NodeFiles]:
    """Return the NODE of `--eds NODE`, if any, and the files without it. Raises Refusal."""
    nodes = [
        path
        for node_id, path in node_files.descriptions
        if node_id is None and not path.suffix and path.name == str(path)
    ]
    if not nodes:
        return None, node_files
    if len(nodes) > 1:
        raise Refusal("one node is read at a time")
    others = tuple(d for d in node_files.descriptions if d != (None, nodes[0]))
    return str(nodes[0]), NodeFiles(node_files.bus_file, others)


def describe_node(
    console: Console,
    access: BusAccess,
    node_files: NodeFiles,
    node: str,
    seconds: float,
    reading: NodeFileOptions,
) -> int:
    """Read a node, write its description, and print its objects; return the exit code."""
    node_index = node_files.read(console)
    node_id = node_index.node(node)
    path = reading.output or Path(f"node_{node_id}.eds")
    require_new(path)
    pace = Pace(min(seconds, _LONGEST_TIMEOUT), reading.rate, reading.limit)
    with terminable(), opened(access.on(node_index)) as bus:
        node_file = read_node(
            BusSession(bus), node_id, path, pace, reading.ranges or AREAS, console.say
        )
    write_new(path, node_file)
    _print(node_file)
    stopped = node_file.stopped
    if node_file.description is None:
        console.say(f"{path} is the EDS that the node has stored (1021h)")
    else:
        count = len(node_file.description.rows)
        guesses = sum(bool(row.guess) for row in node_file.description.rows)
        console.say(f"{path}: {count} values, {guesses} of them with a guess")
    if stopped:
        console.say(f"{path} is partial: {stopped}")
        return INTERRUPTED if stopped.startswith("interrupted") else NO
    return OK


def _print(node_file: NodeFile) -> None:
    if node_file.description is None:
        return
    rows = [tuple(map(translated_word, ("object", "name", "type", "access", "guess")))]
    rows += [
        (*msgspec.structs.astuple(row)[:-1], translated(row.guess))
        for row in node_file.description.rows
    ]
    for line in table(rows):
        write_out(f"{line}\n")
    for line in node_file.description.refused:
        write_text(f"not described: {line}\n")
