"""The command `rtgen docs`: a site of the project's interfaces."""

from __future__ import annotations

import os
from pathlib import Path

import click
from msgspec.structs import replace

from rtgen.cli.definition_options import with_definitions
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.compiler.backends import Artifact
from rtgen.compiler.diagnostics import ToolError, has_errors, in_order
from rtgen.compiler.kit import stages
from rtgen.compiler.project import is_system, output, shown
from rtgen.compiler.project.compilation import Compilation
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, OK

_DEFAULT = "build/docs"


@command()
@with_definitions
@click.option(
    "-o",
    "folder",
    metavar="FOLDER",
    default=_DEFAULT,
    show_default=True,
    help="Write mkdocs.yml and the folder docs there.",
)
@click.option(
    "--title", metavar="TEXT", help="Title of the site; default: the package's name."
)
@click.option(
    "--build", "building", is_flag=True, help="Also build the site in FOLDER/site."
)
@with_console
@with_stages
def docs(
    console: Console,
    definitions: Definitions,
    folder: str,
    title: str | None,
    building: bool,
) -> int:
    """Generate a site about the project's types, components, devices, boards and systems.

    The pages are Markdown, for MkDocs with the theme Material (pip install 'rtgen[docs]'), which
    --build runs. The built site needs no server and no network: open FOLDER/site/index.html.
    rtgen owns FOLDER: obsolete files of earlier runs are removed.
    """
    from rtgen.compiler import compilation
    from rtgen.compiler.systems import reading
    from rtgen.tools.docs.site import site

    profiles = tuple(p for p in definitions.paths if is_system(Path(p)))
    others = tuple(p for p in definitions.paths if p not in profiles)
    project = project_of(replace(definitions, paths=others))
    all_systems = [*map(Path, profiles)] if definitions.paths else project.systems
    result = compilation.read(project, lowered=True)
    if not has_errors(result.diagnostics):
        result = reading.added(
            result,
            all_systems,
            root=project.root,
            output=project.output,
            encoding=project.encoding,
        )
    console.findings(in_order(result.diagnostics), result.sources)
    if has_errors(result.diagnostics):
        return BAD_INPUT
    with stages.stage("pages"):
        files = site(
            title or project.package,
            result.model,
            result.model.systems,
            xcdr2=project.representation == "xcdr2",
            extensibility=project.extensibility,
        )
    target = Path(folder)
    place = target.absolute()
    owned = replace(project, base=place, output=place, skeletons=place)
    output.write(owned, Compilation([Artifact(f.path, f.text, ()) for f in files], {}))
    console.say(f"{shown(target)}: {len(files)} files")
    if building:
        with stages.stage("mkdocs build"):
            _build(target)
        console.say(f"open {shown(target / 'site' / 'index.html')}")
    return OK


def _build(folder: Path) -> None:
    """Run MkDocs. Raises ToolError where it is missing or fails."""
    import subprocess
    import sys
    from importlib.util import find_spec

    if find_spec("material") is None or find_spec("mkdocs") is None:
        raise ToolError(
            "MkDocs with the theme Material is missing",
            hint="pip install 'rtgen[docs]'",
        )
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    # Pages bear the date of the build otherwise.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "0", "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:]
        raise ToolError(f"mkdocs: {' '.join(last)}")
