"""The command `rtgen log plot`: draws values of ports in a recording over time."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.values import curves_of, with_values
from rtgen.cli.options import with_console
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK
from rtgen.tools.running.curves import draw_curves
from rtgen.tools.running.trajectory import check_picture


@command("plot")
@with_values
@click.option(
    "-o",
    "output",
    metavar="FILE",
    required=True,
    help="Output file: .svg, .png or .pdf.",
)
@with_console
def plot_(console: Console, file: Path, selectors: tuple[str, ...], output: str) -> int:
    """Plot values of ports in FILE over time, with a panel for each unit."""
    check_picture(output, "rtgen log plot")
    draw_curves(output, file.name, curves_of(console, file, selectors), "time [s]")
    return OK
