"""The command `rtgen log csv`: values of ports in a recording over time."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.log.values import with_values
from rtgen.cli.options import with_console
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import OK
from rtgen.tools.kit.files import require_different
from rtgen.tools.running.curves import write_curves
from rtgen.tools.running.trajectory import opened


@command("csv")
@with_values
@click.option(
    "-o", "output", metavar="FILE", help="Output file; default: standard output."
)
@with_console
def csv_(
    console: Console, file: Path, selectors: tuple[str, ...], output: str | None
) -> int:
    """Write values of ports in FILE: a column for each value, a row for each time."""
    import io

    from rtgen.cli.log.values import curves_of

    require_different({"-o": output}, file)
    curves = curves_of(console, file, selectors)
    text = io.StringIO()
    write_curves(text, curves)
    with ExitStack() as files:
        stream = opened(files, output)
        if stream is None:
            write_out(text.getvalue())
        else:
            stream.write(text.getvalue())
    return OK
