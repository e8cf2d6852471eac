"""The command `rtgen generate`: compiles definitions and writes the generated files."""

from __future__ import annotations

import click

from rtgen.cli.common import (
    Console,
    Definitions,
    with_console,
    with_definitions,
    with_node_id,
    with_output,
    with_target,
)
from rtgen.cli.compiling.generation import Request, generate_once
from rtgen.cli.compiling.stages import with_stages


@click.command()
@with_definitions
@with_output
@with_node_id
@with_target
@click.option(
    "--representation",
    type=click.Choice(["cdr", "xcdr2"]),
    help="What to_cdr gives where no annotation says it; default: what rtgen.toml says, else cdr.",
)
@click.option(
    "--diff", "only_diff", is_flag=True, help="Print what would change; write nothing."
)
@click.option(
    "--watch", "watching", is_flag=True, help="Go on, and run again on every change."
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
    """Make the files that the definitions ask for.

    PATH is a definition file or a folder of them. Without PATH the sources of rtgen.toml are
    read, which is looked for here and upwards. PATH is read beside them, so the tree stays whole;
    with -o alone. Files that rtgen owns are overwritten, and removed once nothing asks for them.
    Skeletons are created once and then left alone.
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
        from rtgen.cli.compiling.watch import watch

        return watch(console, request)
    return generate_once(console, request)[0]
