"""Selection of values in a recording, as in `--plot` and `--csv` of a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import click

from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.systems.rules import OBSERVABLE
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.curve import Curve
from rtgen.tools.kit.member_units import no_units
from rtgen.tools.recording.events import Log
from rtgen.tools.recording.selection import (
    near_names,
    reported,
    say_losses,
    source,
)
from rtgen.tools.running.curves import Selection


def with_values(command: Callable[..., int]) -> Callable[..., int]:
    """Add the arguments for a file and for values of its ports."""
    for argument in (
        click.argument(
            "selectors",
            nargs=-1,
            required=True,
            metavar="INSTANCE.PORT[.MEMBER]|/TOPIC[.MEMBER]...",
        ),
        click.argument("file", type=click.Path(path_type=Path)),
    ):
        command = argument(command)
    return command


def curves_of(console: Console, file: Path, selectors: Sequence[str]) -> list[Curve]:
    """Return the curves of selectors. Raises ToolError, InputError for ports without samples."""
    chosen = [Selection(text, topics=True) for text in dict.fromkeys(selectors)]
    ports: set[str] = set()
    with reported(file):
        log = Log(file)
        for event in log.events(lambda head: head["event"] == "sample"):
            name = source(event)
            ports.add(name)
            for selection in chosen:
                if selection.whole == name:
                    address = selection.instance, selection.name
                    units = log.units.get(address, no_units)
                    selection.add(event["t"] / SECOND, event["value"], units)
    say_losses(console, log)
    for selection in chosen:
        if selection.whole not in ports:
            hint = near_names(selection.whole, ports)
            message = f"{file}: no samples of {selection.whole}"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])
    return [curve for selection in chosen for curve in selection.curves]
