"""The command `rtgen graph`: draws a system as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.run_table import required, with_run_table
from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Diagnostic, has_errors, in_order
from rtgen.compiler.judging import Judge
from rtgen.compiler.model import Component
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.system_links import known_components
from rtgen.compiler.project import load_around
from rtgen.compiler.systems import checks, timeline
from rtgen.compiler.systems.conditions import SECOND
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK, Refusal
from rtgen.tools.kit.files import save
from rtgen.tools.running.plan import is_fitting


@command()
@with_console
@with_run_table(system="system")
@click.argument("system", metavar="[SYSTEM]", required=False)
@click.option(
    "-o", "output", metavar="FILE", help="Output file; default: standard output."
)
@click.option(
    "--timeline",
    "timeline_file",
    metavar="FILE",
    help="Also draw the connections of this timeline; default: timeline.toml of the folder.",
)
def graph(
    console: Console, system: str | None, output: str | None, timeline_file: str | None
) -> int:
    """Draw a system's components, connections and buses as SVG.

    SYSTEM is an RtsProfile or a folder with system.xml and optionally timeline.toml. The
    definitions of the project, if any, add unconnected ports, the types of all ports, and the buses
    and serial lines of components; a system with connections that do not fit is not drawn.
    """
    from rtgen.compiler.backends.wiring import (
        ComponentView,
        TimedConnection,
        render,
        view_of,
    )
    from rtgen.compiler.systems import reading as systems

    path = Path(required(system))
    if output is not None and Path(output).suffix.lower() not in ("", ".svg"):
        raise Refusal(f"-o {output}: the picture is SVG, so its file ends in .svg")
    profile, findings, sources = systems.read_file(
        path / "system.xml" if path.is_dir() else path
    )
    diagnostics: list[Diagnostic] = list(findings)
    profiles: dict[str, ComponentView] = {}
    buses: Sequence[Bus] = ()
    project, result = load_around(path), None
    if project.sources and not has_errors(diagnostics):
        result = compilation.read(project, lowered=True)
        diagnostics += result.diagnostics
        sources = {**sources, **result.sources}
        declarations = result.model.declarations
        buses = result.model.buses
        profiles = {
            d.name[-1]: view_of(d) for d in declarations if isinstance(d, Component)
        }
        if profile is not None:
            [profile] = systems.as_defined([profile], [result.model])
            components = known_components(systems.models_of(result))
            found = checks.configurations(profile, components)
            diagnostics += checks.as_warnings(found)
    console.findings(in_order(diagnostics), sources)
    if profile is None or has_errors(diagnostics):
        return BAD_INPUT
    plan = timeline.of_system(path, timeline_file, profile)
    console.findings(plan.skipped)
    judge = Judge(project, definitions=result)
    if not is_fitting(judge, profile, plan.steps, console):
        return BAD_INPUT
    timed = [
        TimedConnection(action.source, action.target, step.time / SECOND)
        for step in plan.steps
        if isinstance(action := step.action, timeline.Connect)
    ]
    picture = render(profile, profiles, timed, buses)
    if output is None:
        write_out(picture)
        return OK
    save(Path(output), picture.encode())
    return OK
