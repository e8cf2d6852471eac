"""The command `rtgen inspect`: shows the resolved model."""

from __future__ import annotations

from pathlib import Path

import click
from msgspec.structs import replace

from rtgen.cli.definition_options import with_cache, with_definitions, with_node_id
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.compiler.project import cache, is_component_profile, is_system
from rtgen.tools.compiling import cached
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, OK


def _is_system(path: Path) -> bool:
    """Return whether to read the file as a system; also unknown XML, to report its errors."""
    unknown = path.suffix.lower() == ".xml" and not is_component_profile(path)
    return unknown or is_system(path)


@command()
@with_definitions
@with_cache
@with_node_id
@click.option("--json", "as_json", is_flag=True, help="Print JSON (rtgen-inspect/1).")
@with_console
@with_stages
def inspect(
    console: Console,
    definitions: Definitions,
    no_cache: bool,
    node_id: int | None,
    as_json: bool,
) -> int:
    """Show the resolved model of definitions, devices or systems.

    PATH is a definition file (*.idl, *.cdl, *.eds, *.dcf, *.xdd, *.xdc, RTC.xml, a bus file
    *.toml), a folder of them, or a system (RtsProfile, XML or YAML), which is checked against
    definitions beside it. The default is the sources of rtgen.toml. If the input has errors, only
    the errors are printed; --json also prints the readable part, and includes the diagnostics.
    """
    profiles = [p for p in definitions.paths if _is_system(Path(p))]
    others = tuple(p for p in definitions.paths if p not in profiles)
    project = None
    if others or not profiles:
        project = project_of(replace(definitions, paths=others), node_id=node_id)
    run = cached.inspect(
        project,
        [Path(p) for p in profiles],
        None if no_cache else cache.default(),
        as_json=as_json,
    )
    console.findings(run.diagnostics, run.sources, fold=False)
    if as_json or not run.failed:
        for artifact in run.artifacts:
            write_out(artifact.text)
    return BAD_INPUT if run.failed else OK
