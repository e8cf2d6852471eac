"""The command `rtgen generate`: compiles definitions and writes the generated files."""

from __future__ import annotations

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
from rtgen.tools.compiling.definitions import Definitions
from rtgen.tools.compiling.generation import Request, generate_once
from rtgen.tools.kit.console import Console


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
    definitions: Definitions,
    output: str | None,
    no_cache: bool,
    node_id: int | None,
    target: str | None,
    representation: str | None,
    only_diff: bool,
    watching: bool,
) -> int:
    """Generate files from definitions.

    PATH is a definition file or a folder of such files. Without PATH, the sources of rtgen.toml
    are read, from the working folder or the nearest folder above it. PATH is added to these
    sources, so that the generated tree stays complete; with -o, PATH replaces them. Files that
    rtgen owns are overwritten, and removed when no definition needs them. Skeletons are created
    once and never overwritten.
    """
    request = Request(
        definitions=definitions,
        output=output,
        node_id=node_id,
        target=target,
        representation=representation,
        cached=not no_cache,
        only_diff=only_diff,
    )
    if watching:
        from rtgen.tools.compiling.watch import watch

        return watch(console, request)
    return generate_once(console, request)[0]
