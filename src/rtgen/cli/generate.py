"""The command `rtgen generate`: compiles definitions and writes the generated files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from rtgen.cli.definition_options import (
    with_definitions,
    with_node_id,
    with_output,
    with_target,
)
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.tools.compiling.generation import Request, generate_once
from rtgen.tools.kit.console import Console


def _renames(
    context: click.Context, parameter: click.Parameter, values: Sequence[str]
) -> tuple[tuple[str, str], ...]:
    pairs = [tuple(part.strip() for part in text.split("=")) for text in values]
    for text, pair in zip(values, pairs, strict=True):
        if len(pair) != 2 or not all(pair):
            message = f"{text!r} is not OLD=NEW, as in Heater=Radiator"
            raise click.BadParameter(message, context, parameter)
    return tuple((old, new) for old, new in pairs)


@command()
@with_definitions
@with_output("Write below")
@with_node_id
@with_target
@click.option(
    "--representation",
    type=click.Choice(["cdr", "xcdr2"]),
    help="Representation of types without an annotation; default: from rtgen.toml, else cdr.",
)
@click.option(
    "--rename",
    "renames",
    multiple=True,
    metavar="OLD=NEW",
    callback=_renames,
    help="Rename a component, port, parameter or type first, with all that uses it.",
)
@click.option(
    "--diff", "only_diff", is_flag=True, help="Print what would change; write nothing."
)
@click.option(
    "--watch",
    "watching",
    is_flag=True,
    help="Keep running, and generate again on every change.",
)
@with_console
@with_stages
def generate(
    console: Console,
    /,
    no_cache: bool,
    watching: bool,
    **others: Any,
) -> int:
    """Generate files from definitions.

    PATH is a definition file or a folder of such files. Without PATH, the sources of rtgen.toml
    are read, from the working folder or the nearest folder above it. PATH is added to these
    sources, so that the generated tree stays complete; with -o, PATH replaces them. Files that
    rtgen owns are overwritten, and removed when no definition needs them. Skeletons are created
    once and never overwritten.

    --rename Heater=Radiator, Heater.power=strength or Heating::Power::watt=watts changes the name
    in the definitions, unless that is done already, and in what follows: profiles, systems,
    timelines, settings and behaviours, whose modules are moved. All files are changed, or none.
    """
    request = Request(cached=not no_cache, **others)
    if request.renames and (watching or request.only_diff):
        raise click.UsageError("--rename goes with neither --watch nor --diff")
    if watching:
        from rtgen.tools.compiling.watch import watch

        return watch(console, request)
    return generate_once(console, request)[0]
