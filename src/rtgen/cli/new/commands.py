"""The commands of `rtgen new`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtgen.cli.help import command
from rtgen.cli.new.base import base as base
from rtgen.cli.new.base import generate
from rtgen.cli.options import with_console
from rtgen.compiler.project import Project, load, shown
from rtgen.facts.files import write_atomically
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK

if TYPE_CHECKING:  # loaded by the commands that need it
    from rtgen.compiler.model import Model
    from rtgen.tools.scaffold.names import Names
    from rtgen.tools.scaffold.starters import File, Place


@command()
@click.argument("name", metavar="NAME")
@click.option(
    "--from",
    "source",
    type=click.Choice(["rh3"]),
    help="Copy the reference pipeline instead: RH3 drives to a goal.",
)
@with_console
def project(console: Console, name: str, source: str | None) -> int:
    """Create the folder NAME with a component, a system of two, and their tests.

    NAME may have dots: `acme.rover` is the package `rover` in `acme`.
    """
    from rtgen.tools.scaffold import starters, writing
    from rtgen.tools.scaffold.names import project_names

    package, forms = project_names(name)
    target = Path(name)
    with writing.new_folder(target) as folder:
        if source == "rh3":
            writing.write(starters.reference(folder))
        else:
            writing.write(starters.project(forms, package, folder))
            (folder / "systems").mkdir()
            created = load(folder)
            place = starters.place_of(created)
            model = model_of(created)
            twice = [starters.FIRST] * 2
            writing.write(starters.system(forms, place, model, twice)[0])
            settings = starters.project_settings(forms, place, complete=True)
            write_atomically(settings.path, settings.text.encode())
        generate(console, load(folder))
    console.say(f"{shown(target)}: created; see {shown(target / 'README.md')}")
    return OK


@command()
@click.argument("name", metavar="NAME")
@with_console
def component(console: Console, name: str) -> int:
    """Add a component: its definition, behaviour and test."""
    from rtgen.tools.scaffold import starters

    return _add(console, name, starters.component)


@command()
@click.argument("name", metavar="NAME")
@with_console
def device(console: Console, name: str) -> int:
    """Add a CANopen device: its EDS, a bus with it, behaviour and test."""
    from rtgen.tools.scaffold import starters

    return _add(console, name, starters.device)


@command()
@click.argument("name", metavar="NAME")
@with_console
def board(console: Console, name: str) -> int:
    """Add a TECS board: CDL with a signature and a join, and a test over TCP."""
    from rtgen.tools.scaffold import starters

    return _add(console, name, starters.board)


@command()
@click.argument("name", metavar="NAME")
@click.argument("components", nargs=-1, metavar="[COMPONENT]...")
@with_console
def system(console: Console, name: str, components: tuple[str, ...]) -> int:
    """Add a system of components of the project, and a test that runs it.

    COMPONENT may be repeated; the default is one of each component that needs neither a bus nor a
    board. Data flows in this order: an InPort is connected to the nearest preceding OutPort of its
    type, a consumer to the nearest provider of its interface; other ports that fit are reported.
    The component of a device, which its bus connects, has no connections.
    """
    from rtgen.tools.scaffold import starters

    ambiguous: list[str] = []

    def files_of(forms: Names, place: Place) -> Sequence[File]:
        files, diagnostics = starters.system(forms, place, model_of(load()), components)
        ambiguous.extend(diagnostics)
        return files

    code = _add(console, name, files_of)
    for text in ambiguous:
        console.say(text)
    return code


@command()
@click.argument("name", metavar="NAME", required=False)
@with_console
def template(console: Console, name: str | None) -> int:
    """Copy the template NAME into the folder `[templates] path`; without NAME, list them all.

    The copy takes the place of the original for this project.
    """
    from rtgen.tools.scaffold import templates, writing

    if name is None:
        write_out(templates.listing())
        return OK
    file = templates.copy_of(name)
    with writing.added([file]):
        generate(console, load())
    console.say(f"created: {shown(file.path)}")
    return OK


@command()
@click.argument("name", metavar="NAME")
@with_console
def backend(console: Console, name: str) -> int:
    """Create the folder NAME with a back end: a package that extends rtgen once installed."""
    from rtgen.tools.scaffold import starters, writing
    from rtgen.tools.scaffold.names import names

    forms = names(name)
    target = Path(name)
    with writing.new_folder(target) as folder:
        writing.write(starters.backend(forms, folder))
    console.say(f"{shown(target)}: created; see {shown(target / 'README.md')}")
    return OK


def _add(
    console: Console, name: str, files_of: Callable[[Names, Place], Sequence[File]]
) -> int:
    from rtgen.tools.scaffold import starters, writing
    from rtgen.tools.scaffold.names import names

    forms = names(name)
    files = files_of(forms, starters.place_of(load()))
    with writing.added(files):
        generate(console, load())
    console.say(f"created: {', '.join(shown(file.path) for file in files)}")
    return OK


def model_of(project: Project) -> Model:
    """Return the components of the project. Raises InputError if its definitions have errors."""
    from rtgen.compiler import compilation
    from rtgen.compiler.diagnostics import InputError, has_errors

    result = compilation.read(project, lowered=True)
    if has_errors(result.diagnostics):
        raise InputError(result.diagnostics)
    return result.model
