"""Options shared by the commands of `rtgen can`: which bus, and descriptions of its nodes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from rtgen.cli.help import gathered
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.runtime.canopen.bus.python_can import Option, option
from rtgen.tools.can.access import CHANNEL, BusAccess, NodeFiles


def _arguments(
    context: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> dict[str, Option]:
    arguments: dict[str, Option] = {}
    for text in values:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier():
            raise click.BadParameter(f"{text!r} is not KEY=VALUE", context, parameter)
        arguments[name] = option(value)
    return arguments


def _descriptions(
    context: click.Context, parameter: click.Parameter, values: tuple[Any, ...]
) -> tuple[tuple[int | None, Path], ...]:
    descriptions: list[tuple[int | None, Path]] = []
    for text in values:
        node, equals, path = text.partition("=")
        if not equals:
            descriptions.append((None, Path(text)))
            continue
        try:
            node_id = int(node, 0)
        except ValueError:
            node_id = 0
        if not 1 <= node_id <= 127:
            message = f"{node!r} is not a node-id (1 to 127)"
            raise click.BadParameter(message, context, parameter)
        descriptions.append((node_id, Path(path)))
    return tuple(descriptions)


with_bus = gathered(
    "access",
    BusAccess,
    click.option(
        "--interface",
        metavar="NAME",
        help="python-can's: socketcan, socketcand, slcan, ...",
    ),
    click.option("--channel", metavar="NAME", help=f"Default: {CHANNEL}."),
    click.option(
        "--bitrate",
        type=WholeRange(min=1),
        metavar="N",
        help="In bit/s; default: the bus file's, else the interface's.",
    ),
    click.option(
        "--option",
        "further",
        multiple=True,
        metavar="KEY=VALUE",
        callback=_arguments,
        help="For the interface, such as host=127.0.0.1.",
    ),
    title="Bus",
)

with_nodes = gathered(
    "node_files",
    NodeFiles,
    click.option(
        "--bus",
        "bus_file",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="Bus file with the nodes; default: the project's.",
    ),
    click.option(
        "--eds",
        "descriptions",
        multiple=True,
        metavar="NODE-ID=FILE",
        callback=_descriptions,
        help="EDS, DCF, XDD or XDC of a node; a DCF or XDC may have its id.",
    ),
    title="Bus",
)


def with_span(function: Callable[..., int]) -> Callable[..., int]:
    """Add --for and --count; the function gets `seconds` and `count`."""
    function = click.option(
        "--for",
        "seconds",
        type=FiniteRange(min=0, min_open=True),
        metavar="SECONDS",
        help="Stop after this time; default: at Ctrl-C.",
    )(function)
    return click.option(
        "--count",
        type=WholeRange(min=1),
        metavar="N",
        help="Stop after N frames.",
    )(function)
