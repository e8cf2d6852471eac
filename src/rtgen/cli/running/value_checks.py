"""The option of commands that run a system: which values of samples and calls are checked."""

from __future__ import annotations

import click

from rtgen.facts.value_checks import CheckValues

with_value_checks = click.option(
    "--check-values",
    type=click.Choice([each.value for each in CheckValues]),
    default=CheckValues.FIRST.value,
    show_default=True,
    help="Check values of samples and calls in the process: all, the first and some, or none.",
)
