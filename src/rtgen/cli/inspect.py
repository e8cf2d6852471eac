"""`rtgen inspect`."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen import cache, compiler
from rtgen.cli.common import (
    BAD_INPUT,
    OK,
    Console,
    project_of,
    with_cache,
    with_console,
    with_definitions,
    write_out,
)


@click.command()
@with_definitions
@with_cache
@click.option("--json", "as_json", is_flag=True, help="Print JSON (rtgen-inspect/1).")
@with_console
def inspect(
    console: Console,
    paths: tuple[str, ...],
    include: tuple[str, ...],
    define: list[tuple[str, str]],
    ignore_case_clashes: bool,
    no_cache: bool,
    as_json: bool,
) -> int:
    """Show the resolved model of definitions or systems.

    PATH is a definition file, a folder of them, or a system (RtsProfile, *.xml). Without PATH
    the sources of rtgen.toml are shown.
    """
    profiles = [p for p in paths if p.lower().endswith(".xml")]
    definitions = [p for p in paths if p not in profiles]
    project = None
    if definitions or not profiles:
        project = project_of(definitions, include, define, ignore_case_clashes)
    run = compiler.inspect(
        project,
        [Path(p) for p in profiles],
        None if no_cache else cache.default(),
        as_json=as_json,
    )
    console.findings(run.diagnostics, run.sources)
    for artifact in run.artifacts:
        write_out(artifact.text)
    return BAD_INPUT if run.failed else OK
