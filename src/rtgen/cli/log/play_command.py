"""The command `rtgen log play`: prints the events of a recording as they came."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.common import with_choice
from rtgen.cli.options import with_console
from rtgen.cli.running_options import RATE, with_end_of_replay
from rtgen.tools.kit.console import Console
from rtgen.tools.recording.selection import Choice
from rtgen.tools.running.replaying import printed


@command("play")
@click.argument("file", type=click.Path(path_type=Path))
@with_choice
@click.option(
    "--rate",
    type=RATE,
    default=1.0,
    metavar="FACTOR",
    help="Recorded seconds per second; default: 1.",
)
@with_end_of_replay
@with_console
def play_(
    console: Console,
    file: Path,
    names: tuple[str, ...],
    kinds: tuple[str, ...],
    rate: float,
    until: float | None,
) -> int:
    """Print the events of FILE as lines of JSON, each at its time.

    Names select instances, ports and buses; the default is all events. `rtgen log cat` prints the
    same at once, `rtgen replay` runs components with them.
    """
    return printed(console, file, rate, until, Choice(names, kinds))
