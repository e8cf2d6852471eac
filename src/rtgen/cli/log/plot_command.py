"""The command `rtgen log plot`: draws values of ports in a recording over time."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.values import curves_of, with_values
from rtgen.cli.options import with_console
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK
from rtgen.tools.kit.files import values_file
from rtgen.tools.running.curves import draw_curves
from rtgen.tools.running.trajectory import check_picture


@command("plot")
@with_values
@click.option(
    "-o",
    "output",
    metavar="FILE",
    help="Output file: .svg, .png or .pdf; default: build/NAME/values.svg.",
)
@with_console
def plot_(
    console: Console, file: Path, selectors: tuple[str, ...], output: str | None
) -> int:
    """Plot values of ports in FILE over time, with a panel for each unit."""
    if output is not None:
        check_picture(output, "rtgen log plot")
    curves = curves_of(console, file, selectors)
    if output is None:
        output = str(values_file(file.stem, ".svg"))
        check_picture(output, "rtgen log plot")
        console.say(f"results: {output}")
    draw_curves(output, file.name, curves, "time [s]")
    return OK
