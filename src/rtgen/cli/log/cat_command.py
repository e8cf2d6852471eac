"""The command `rtgen log cat`: prints the events of a recording."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.common import with_choice
from rtgen.cli.options import with_console
from rtgen.tools.kit.console import Console
from rtgen.tools.recording.selection import Choice
from rtgen.tools.running.replaying import printed


@command("cat")
@click.argument("file", type=click.Path(path_type=Path))
@with_choice
@with_console
def cat_(
    console: Console, file: Path, names: tuple[str, ...], kinds: tuple[str, ...]
) -> int:
    """Print the events of FILE as lines of JSON, in the format of `rtgen run --log`.

    Names select instances, ports and buses; the default is all events.
    """
    return printed(console, file, choice=Choice(names, kinds))
