"""Stages of a run as shown by commands: durations with `-v`, progress on a terminal."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Concatenate, ParamSpec

import click

from rtgen.cli.help import MESSAGES, grouped
from rtgen.tools.compiling.shown_stages import shown
from rtgen.tools.kit.console import Console

P = ParamSpec("P")


def with_stages(
    function: Callable[Concatenate[Console, P], int],
) -> Callable[..., int]:
    """Add -v, and show the stages of the run; place it below `with_console`."""

    @grouped(
        MESSAGES,
        click.option(
            "-v",
            "--verbose",
            "verbose",
            is_flag=True,
            help="Print the time of each stage on standard error.",
        ),
    )
    @functools.wraps(function)
    def wrapped(
        console: Console, /, verbose: bool, *args: P.args, **kwargs: P.kwargs
    ) -> int:
        console.verbose = verbose
        with shown(console):
            return function(console, *args, **kwargs)

    return wrapped
