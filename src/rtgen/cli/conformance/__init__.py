"""The command `rtgen conformance`: tests a real device against its definition."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from rtgen.cli.can.options import BusAccess, with_bus
from rtgen.cli.common import (
    NO,
    OK,
    Console,
    FiniteRange,
    Refusal,
    with_console,
    write_out,
)
from rtgen.diagnostics import ToolError

_DESCRIPTIONS = (".eds", ".dcf")


@click.command("conformance")
@click.argument("file", metavar="FILE", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--connect",
    metavar="INTERFACE:CHANNEL",
    help="The bus in one word, such as socketcan:can0, for --interface and --channel.",
)
@click.option(
    "--node",
    "node_id",
    type=click.IntRange(1, 127),
    metavar="NODE-ID",
    help="The node-id; default: that of a DCF.",
)
@click.option(
    "--actuate",
    is_flag=True,
    help="Make the checks that may move something, too: OPERATIONAL, writes to the application.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--junit",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write JUnit's XML to a file, too.",
)
@click.option(
    "--html",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write a page to a file, too.",
)
@click.option(
    "--timeout",
    type=FiniteRange(min=0.01),
    default=1.0,
    show_default=True,
    metavar="S",
    help="Seconds within which the node must answer.",
)
@click.option(
    "--boot",
    type=FiniteRange(min=0.01),
    default=5.0,
    show_default=True,
    metavar="S",
    help="Seconds within which the node must boot.",
)
@with_bus
@with_console
def conformance(
    console: Console,
    access: BusAccess,
    file: Path,
    connect: str | None,
    node_id: int | None,
    actuate: bool,
    as_json: bool,
    junit: Path | None,
    html: Path | None,
    timeout: float,
    boot: float,
) -> int:
    """Test a CANopen node against its EDS or DCF.

    The node is read, asked for what it must refuse, and its communication is reset; it ends in
    PRE-OPERATIONAL with the values that it had. Nothing that it drives moves, unless --actuate
    permits it. Exit code 1: a check has failed.
    """
    from rtgen.cli.conformance.canopen.testing import tested
    from rtgen.cli.conformance.report import as_html, as_json_text, as_junit, as_text

    if file.suffix.lower() not in _DESCRIPTIONS:
        raise Refusal(f"{file} is not an EDS or a DCF")
    if connect is not None:
        interface, _, channel = connect.partition(":")
        if not interface or not channel:
            message = f"{connect!r} is not INTERFACE:CHANNEL"
            raise click.BadParameter(message, param_hint="--connect")
        access = replace(access, interface=interface, channel=channel)
    report = tested(file, node_id, access, timeout=timeout, boot=boot, actuate=actuate)
    write_out(as_json_text(report) if as_json else as_text(report))
    for path, form in ((junit, as_junit), (html, as_html)):
        if path is not None:
            _write(path, form(report))
    return OK if report.passed else NO


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error
