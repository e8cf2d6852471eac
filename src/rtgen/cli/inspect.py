"""`rtgen inspect`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click

from rtgen import compiler
from rtgen.cli.common import (
    BAD_INPUT,
    OK,
    Console,
    with_console,
    with_definitions,
    write_out,
)
from rtgen.diagnostics import Diagnostic, has_errors, in_order
from rtgen.model import Model, System
from rtgen.project import load, require_sources, with_arguments


@click.command()
@with_definitions
@click.option("--json", "as_json", is_flag=True, help="Print JSON (rtgen-inspect/1).")
@with_console
def inspect(
    console: Console,
    paths: tuple[str, ...],
    include: tuple[str, ...],
    define: list[tuple[str, str]],
    as_json: bool,
) -> int:
    """Show the resolved model of definitions or systems.

    PATH is a definition file, a folder of them, or a system (RtsProfile, *.xml). Without PATH
    the sources of rtgen.toml are shown.
    """
    from rtgen.inspect import inspect as to_json
    from rtgen.inspect import tree

    profiles = [p for p in paths if p.lower().endswith(".xml")]
    definitions = [p for p in paths if p not in profiles]
    project = with_arguments(load(), paths=definitions, include=include, define=define)
    diagnostics: list[Diagnostic] = []
    sources: dict[str, str] = {}
    model = Model()
    if definitions or not profiles:
        require_sources(project)
        result = compiler.read(project)
        model = result.model
        diagnostics += result.diagnostics
        sources |= result.sources
    systems: list[System] = []
    for profile in profiles:
        system, found, texts = compiler.read_system(Path(profile))
        systems += [system] if system is not None else []
        diagnostics += found
        sources |= texts
    model = replace(model, systems=(*model.systems, *systems))
    diagnostics = in_order(diagnostics)
    console.findings(diagnostics, sources)
    if as_json:
        write_out(
            json.dumps(to_json(model, diagnostics), indent=2, ensure_ascii=False) + "\n"
        )
    else:
        write_out(tree(model))
    return BAD_INPUT if has_errors(diagnostics) else OK
