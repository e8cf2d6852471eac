"""The command `rtgen convert`: writes a component, system, bus or device in another form."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.compiler.project import is_bus_file
from rtgen.facts.device_files import is_device_file
from rtgen.tools.can.dbc.conversion import OF_BUSES, converted_bus
from rtgen.tools.can.descriptions.conversion import OF_DEVICES, converted_device
from rtgen.tools.components.conversion import OF_COMPONENTS, OF_SYSTEMS, converted
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK


@command()
@click.argument("file", metavar="FILE")
@click.option(
    "--to",
    "to",
    type=click.Choice((*OF_COMPONENTS, *OF_SYSTEMS, *OF_BUSES, *OF_DEVICES)),
    metavar="FORM",
    help="idl, rtc-xml, rtc-yaml, rts-xml, rts-yaml, dbc, eds, dcf, xdd, xdc; by default the "
    "natural other one.",
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
@click.option(
    "--node-id",
    type=click.IntRange(1, 127),
    metavar="N",
    help="The node-id in a DCF or XDC.",
)
@with_console
def convert(
    console: Console,
    file: str,
    to: str | None,
    component: str | None,
    output: str | None,
    include: tuple[str, ...],
    node_id: int | None,
) -> int:
    """Convert a component, a system, a bus or a device to another format, on standard output.

    FILE is a definition with a component (*.idl), an RtcProfile (RTC.xml, or the YAML that
    rtc-template writes), an RtsProfile (XML, or the YAML of rtshell), a bus file (*.toml), or a
    module of OpenRTM-aist-Python (*.py), generated or written by hand: nothing of it is executed,
    and what only running it would tell is reported. A profile of the wanted format is copied
    unchanged. A description of a device (*.eds, *.dcf, *.xdd, *.xdc) is written so that other
    tools read it; what was changed for that, and why, is listed.
    """
    if is_device_file(Path(file)) and to not in OF_COMPONENTS:
        result = converted_device(console, Path(file), to, node_id)
    elif is_bus_file(Path(file)):
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
        from shlex import join

        places = " ".join(join(["-I", each.as_posix()]) for each in further)
        console.say(f"to generate from it, name the folder of its includes: {places}")
    return OK
