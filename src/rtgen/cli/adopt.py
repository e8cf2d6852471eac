"""`rtgen adopt`."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.common import BAD_INPUT, OK, Console, with_console, write_out
from rtgen.diagnostics import ToolError, has_errors, in_order


@click.command()
@click.argument("file", metavar="FILE")
@click.option("-o", "output", metavar="DIR", help="Write DIR/<Component>.idl instead.")
@click.option(
    "-I",
    "include",
    multiple=True,
    metavar="DIR",
    help="Look for the types of ports in the IDL files there.",
)
@with_console
def adopt(
    console: Console, file: str, output: str | None, include: tuple[str, ...]
) -> int:
    """Make a definition of a component of OpenRTM-aist-Python, on standard output.

    FILE is a module as RTCBuilder or rtc-template make it. It is read, never executed: what is
    computed when it runs is told, and left out.
    """
    from rtgen import component_profiles
    from rtgen.cli.component_text import component_idl
    from rtgen.frontends import idl, openrtm_python, together
    from rtgen.frontends.rtc_profile import Profiles
    from rtgen.model import Component, SourceFile
    from rtgen.project import load

    module = openrtm_python.read(Path(file))
    if module.profile is None:
        console.findings(module.diagnostics, {file: module.source})
        return BAD_INPUT
    project = load()
    folders = [Path(folder) for folder in include]
    definitions = [path for f in folders for path in sorted(f.glob("*.idl"))]
    definitions += [p for p in project.sources if p.suffix.lower() == ".idl"]
    shown = module.profile.file
    profiles = Profiles(
        (module.profile,),
        (SourceFile(name=shown, key=Path(file).name, sha256="", main=True),),
        module.diagnostics,
        {shown: module.source},
    )
    needed = component_profiles.needed(profiles, definitions)
    types = idl.load(
        definitions,
        root=project.root,
        include=(*folders, *project.include),
        virtual=needed.virtual,
    )
    made = together(needed.results(types))
    found = in_order(made.diagnostics)
    console.findings(found, made.sources)
    if has_errors(found):
        return BAD_INPUT
    component = next(
        d
        for d in made.model.declarations
        if isinstance(d, Component) and d.file == shown
    )
    text = component_idl(made.model, component)
    if output is None:
        write_out(text)
        return OK
    target = Path(output) / f"{component.name[-1]}.idl"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("x", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
    except FileExistsError:
        raise ToolError(f"{target.as_posix()} is there already") from None
    except OSError as error:
        raise ToolError(
            f"cannot write {target.as_posix()}: {error.strerror}"
        ) from error
    console.say(f"{target.as_posix()} written")
    return OK
