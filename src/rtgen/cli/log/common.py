"""Options and helpers of `rtgen log`: selection of events, errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import click

from rtgen.cli.common import Console
from rtgen.diagnostics import ToolError
from rtgen.recording.errors import RecordingError
from rtgen.recording.events import Log
from rtgen.recording.mcap_reader import McapFile

KINDS = (
    "sample",
    "state",
    "parameter",
    "connection",
    "frame",
    "call",
    "component",
    "run",
)
"""The kinds of events; a log of JSON lines has the first two."""


@contextmanager
def reported() -> Iterator[None]:
    """Convert errors of recordings to ToolError within the block."""
    try:
        yield
    except RecordingError as error:
        raise ToolError(str(error), hint=error.hint) from error


def say_losses(console: Console, log: Log | McapFile) -> None:
    """Print what could not be read of a log, of which all events were read."""
    for loss in log.losses():
        console.say(f"{log.path}: {loss}")


def with_choice(command: Callable[..., int]) -> Callable[..., int]:
    """Add the arguments that select events."""
    options = (
        click.argument("names", nargs=-1, metavar="[INSTANCE[.PORT]]..."),
        click.option(
            "--event",
            "kinds",
            type=click.Choice(KINDS),
            multiple=True,
            help="Only events of this kind; may be repeated.",
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


def choice(
    names: Sequence[str], kinds: Sequence[str]
) -> Callable[[Mapping[str, Any]], bool]:
    """Return a predicate of events, by kind, and by instance, port or bus."""

    def wanted(event: Mapping[str, Any]) -> bool:
        if kinds and event["event"] not in kinds:
            return False
        return not names or not {*_names(event)}.isdisjoint(names)

    return wanted


def source(event: Mapping[str, Any]) -> str:
    """Return the source of an event: `INSTANCE.PORT`, an instance, a bus; empty for the run."""
    names = [*_names(event)]
    return names[-1] if names else ""


def _names(event: Mapping[str, Any]) -> Iterator[str]:
    instance, port, bus = (
        str(event.get(key, "")) for key in ("instance", "port", "bus")
    )
    yield from filter(None, (instance, bus))
    if port:
        yield f"{instance}.{port}" if instance else port
