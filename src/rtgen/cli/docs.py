"""The command `rtgen docs`: a site of the project's interfaces."""

from __future__ import annotations

from pathlib import Path

import click
from msgspec.structs import replace

from rtgen.cli.definition_options import with_definitions
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.compiler.backends import Artifact
from rtgen.compiler.diagnostics import has_errors, in_order
from rtgen.compiler.kit import stages
from rtgen.compiler.project import is_system, output, shown
from rtgen.compiler.project.compilation import Compilation
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, OK

_PAGES, _SITE = "build/docs", "build/site"
"""Default folders of pages, and of a built site."""


@command()
@with_definitions
@click.option(
    "-o",
    "folder",
    metavar="FOLDER",
    help=f"Default: {_PAGES}; with --build {_SITE}.",
)
@click.option(
    "--title", metavar="TEXT", help="Title of the site; default: the package's name."
)
@click.option(
    "--build", "building", is_flag=True, help="Build the site: FOLDER/index.html."
)
@with_console
@with_stages
def docs(
    console: Console,
    definitions: Definitions,
    folder: str | None,
    title: str | None,
    building: bool,
) -> int:
    """Generate a site about the project's types, components, devices, boards and systems.

    FOLDER gets the pages in Markdown, for MkDocs with the theme Material (the extra
    `docs`); with --build it gets the site that MkDocs makes of them, which needs no server
    and no network. It belongs to rtgen: obsolete files of earlier runs are removed.
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
    if building:
        from rtgen.tools.docs.building import build

        target = Path(folder or _SITE)
        with stages.stage("mkdocs build"):
            build(files, target)
        console.say(f"open {shown(target / 'index.html')}")
        return OK
    target = Path(folder or _PAGES)
    place = target.absolute()
    owned = replace(project, base=place, output=place, skeletons=place)
    output.write(owned, Compilation([Artifact(f.path, f.text, ()) for f in files], {}))
    console.say(f"{shown(target)}: {len(files)} files")
    return OK
