"""Options and helpers of `rtgen log`: selection of events, errors."""

from __future__ import annotations

from collections.abc import Callable

import click

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
