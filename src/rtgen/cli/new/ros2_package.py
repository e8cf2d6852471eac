"""The command `rtgen new ros2-package`."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.new.base import generate
from rtgen.cli.new.commands import model_of
from rtgen.cli.options import with_console
from rtgen.compiler.project import load, shown
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK


@command("ros2-package")
@click.argument("name", metavar="NAME")
@click.option(
    "--system",
    "systems",
    multiple=True,
    type=click.Path(exists=True, path_type=Path),
    metavar="SYSTEM",
    help="A system to launch (repeatable); default: those of the project.",
)
@click.option(
    "--folder",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="FOLDER",
    help="Where the packages are; default: ros2 in the project.",
)
@with_console
def ros2_package(
    console: Console, name: str, systems: tuple[Path, ...], folder: Path | None
) -> int:
    """Add packages that colcon builds: NAME with the systems, and those of interfaces.

    NAME has a program and a launch file for each system, and links to the files of the project.
    Each module with types that ROS 2 has is a package of interface files, which are links to the
    generated ones if `[ros2] interfaces` is true. A package of interfaces that exists is kept.
    """
    from rtgen.tools.scaffold import ros_packages, starters, writing

    project = load()
    starters.require_project(project)
    folder = folder or project.root / "ros2"
    writing.require_absent([folder / name])
    made = ros_packages.packages(name, project, model_of(project), systems, folder)
    console.findings(made.findings)
    with writing.added(made.files):
        generate(console, load())
    for each in made.names:
        console.say(f"created: {shown(folder / each)}")
    if made.existing:
        console.say(f"left as they are: {', '.join(made.existing)}")
    if made.missing:
        console.say(f"package.xml has no {made.missing} yet: see [ros2] in rtgen.toml")
    return OK
