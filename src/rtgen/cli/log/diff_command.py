"""The command `rtgen log diff`: compares two recordings, source by source."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.common import with_choice
from rtgen.cli.options import with_console
from rtgen.compiler.kit.translation import translated
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.recording.comparison import compare
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.selection import Choice, reported, say_losses


@command("diff")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("other", type=click.Path(path_type=Path))
@with_choice
@with_console
def diff_(
    console: Console,
    file: Path,
    other: Path,
    names: tuple[str, ...],
    kinds: tuple[str, ...],
) -> int:
    """Compare the events of FILE and OTHER, MCAP or JSON lines.

    The events of each source (port, bus and so on) are compared in order, and the first difference
    of each source is shown. Only kinds of events that both formats contain are compared. Exit code
    1: the files differ.
    """
    with reported(file, other):
        logs = Log(file), Log(other)
        if any(log.recording is None for log in logs) and not kinds:
            kinds = ("sample", "state")
        choice = Choice(names, kinds)
        compared = compare(*logs, choice)
    for log in logs:
        say_losses(console, log)
    choice.check(file, other)
    for (kind, name), of in compared.items():
        if text := of.text():
            head = f"{kind} {name}:".replace(" :", ":")
            write_out(f"{head} {translated(text)}\n")
    differ = sum(bool(of.text()) for of in compared.values())
    equal = sum(of.same for of in compared.values())
    console.say(f"{equal} events are equal; {differ} of {len(compared)} sources differ")
    return NO if differ else OK
