"""`rtgen graph`."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen import compiler
from rtgen.cli.common import BAD_INPUT, OK, Console, with_console, write_out
from rtgen.diagnostics import Diagnostic, ToolError, has_errors, in_order
from rtgen.model import Component
from rtgen.project import load


@click.command()
@click.argument("system", metavar="SYSTEM")
@click.option(
    "-o", "output", metavar="FILE", help="Write there instead of standard output."
)
@with_console
def graph(console: Console, system: str, output: str | None) -> int:
    """Draw a system's components and connections as SVG.

    SYSTEM is an RtsProfile or a folder with system.xml. The project's definitions, if there are
    any, tell the ports that are not connected and the types of all.
    """
    from rtgen.backends.wiring import ComponentView, render, view_of

    path = Path(system)
    profile, found, sources = compiler.read_system(
        path / "system.xml" if path.is_dir() else path
    )
    diagnostics: list[Diagnostic] = list(found)
    profiles: dict[str, ComponentView] = {}
    project = load()
    if project.sources and not has_errors(diagnostics):
        result = compiler.read(project, lowered=True)
        diagnostics += result.diagnostics
        sources = {**sources, **result.sources}
        declarations = result.model.declarations
        profiles = {
            d.name[-1]: view_of(d) for d in declarations if isinstance(d, Component)
        }
    console.findings(in_order(diagnostics), sources)
    if profile is None or has_errors(diagnostics):
        return BAD_INPUT
    picture = render(profile, profiles)
    if output is None:
        write_out(picture)
        return OK
    try:
        Path(output).write_text(picture, encoding="utf-8", newline="\n")
    except OSError as error:
        raise ToolError(f"cannot write {output}: {error.strerror}") from error
    return OK
