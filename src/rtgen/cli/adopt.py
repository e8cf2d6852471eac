"""The command `rtgen adopt`: derives an IDL definition from an OpenRTM-aist-Python component."""

from __future__ import annotations

from pathlib import Path

import click

from rtgen.cli.common import BAD_INPUT, OK, Console, with_console, write_out
from rtgen.diagnostics import ToolError


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

    FILE is a module as RTCBuilder, rtc-template or rtgen make it, or as people write it; modules of
    the same repository that it imports are read, too. Nothing is executed: what only running the
    module settles is reported.
    """
    from rtgen.cli.components.adopted import adopted
    from rtgen.cli.components.component_text import component_idl

    found = adopted(Path(file), [Path(folder) for folder in include])
    console.findings(found.diagnostics, found.sources)
    if found.component is None:
        return BAD_INPUT
    component = found.component
    text = component_idl(found.model, component)
    if output is None:
        write_out(text)
        return OK
    target = Path(output) / f"{component.name[-1]}.idl"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("x", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
    except FileExistsError:
        raise ToolError(f"{target.as_posix()} exists already") from None
    except OSError as error:
        raise ToolError(
            f"cannot write {target.as_posix()}: {error.strerror}"
        ) from error
    console.say(f"{target.as_posix()} written")
    return OK
