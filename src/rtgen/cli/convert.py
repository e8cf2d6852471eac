"""The command `rtgen convert`: writes a component, a system or a bus in another form."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.project import is_bus_file
from rtgen.tools.can.dbc.conversion import OF_BUSES, converted_bus
from rtgen.tools.components.conversion import OF_COMPONENTS, OF_SYSTEMS, converted
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK


@command()
@click.argument("file", metavar="FILE")
@click.option(
    "--to",
    "to",
    type=click.Choice((*OF_COMPONENTS, *OF_SYSTEMS, *OF_BUSES)),
    metavar="FORM",
    help="idl, rtc-xml, rtc-yaml, rts-xml, rts-yaml, dbc; by default the natural other one.",
)
@click.option(
    "--component",
    metavar="NAME",
    help="Name of the component, if FILE defines several.",
)
@click.option("-o", "output", metavar="DIR", help="Write a new file there instead.")
@click.option(
    "-I",
    "include",
    multiple=True,
    metavar="DIR",
    help="Search DIR for included files and for types of ports.",
)
@with_console
def convert(
    console: Console,
    file: str,
    to: str | None,
    component: str | None,
    output: str | None,
    include: tuple[str, ...],
) -> int:
    """Convert a component, a system or a bus to another format, on standard output.

    FILE is a definition with a component (*.idl), an RtcProfile (RTC.xml, or the YAML that
    rtc-template writes), an RtsProfile (XML, or the YAML of rtshell), a bus file (*.toml), or a
    module of OpenRTM-aist-Python (*.py), generated or written by hand: nothing of it is executed,
    and what only running it would tell is reported. A profile of the wanted format is copied
    unchanged.
    """
    if is_bus_file(Path(file)):
        result = converted_bus(console, Path(file), to)
    else:
        result = converted(console, file, to, component, include)
    if output is None:
        write_out(result.content)
        return OK
    folder = Path(output)
    console.say(f"{result.write(folder).as_posix()} written")
    searched = [folder.resolve(), folder.resolve() / "idl"]
    further = [each for each in result.folders if each.resolve() not in searched]
    if further:
        places = " ".join(f"-I {each.as_posix()}" for each in further)
        console.say(f"to generate from it, name the folder of its includes: {places}")
    return OK
