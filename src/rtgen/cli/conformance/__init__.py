"""The command `rtgen conformance`: tests a real device or board against its definition."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtgen.cli.can.options import BusAccess, with_bus
from rtgen.cli.common import (
    NO,
    OK,
    Console,
    FiniteRange,
    Refusal,
    WholeRange,
    with_console,
    write_out,
)
from rtgen.cli.rpc.common import Peer, Wire, with_representation
from rtgen.diagnostics import ToolError
from rtgen.runtime.opaque_rpc.serial import BAUDRATE

if TYPE_CHECKING:
    from rtgen.cli.conformance.report import Report

_DESCRIPTIONS = (".eds", ".dcf")


@click.command("conformance")
@click.argument("file", metavar="FILE", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--connect",
    metavar="WAY:WHERE",
    help="tcp:HOST:PORT or serial:DEVICE of a board; or a bus in one word, such as "
    "socketcan:can0, for --interface and --channel.",
)
@click.option(
    "--node",
    "node_id",
    type=WholeRange(1, 127),
    metavar="NODE-ID",
    help="The node-id; default: that of a DCF.",
)
@click.option(
    "--actuate",
    is_flag=True,
    help="Make the checks that may move something, too: OPERATIONAL, writes to the application, "
    "calls of functions.",
)
@click.option(
    "--signature",
    metavar="SIG",
    help="The signature of the board, if there are several.",
)
@click.option(
    "--function",
    "functions",
    multiple=True,
    metavar="NAME",
    help="Call this function of the board only; may be repeated.",
)
@click.option(
    "--baud",
    type=WholeRange(min=1),
    default=BAUDRATE,
    show_default=True,
    help="Of a serial line.",
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
    help="Seconds within which the node or board must answer.",
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
@with_representation
@with_console
def conformance(
    console: Console,
    access: BusAccess,
    wire: Wire,
    file: Path,
    connect: str | None,
    node_id: int | None,
    actuate: bool,
    signature: str | None,
    functions: tuple[str, ...],
    baud: int,
    as_json: bool,
    junit: Path | None,
    html: Path | None,
    timeout: float,
    boot: float,
) -> int:
    """Test a CANopen node against its EDS or DCF, or a TECS board against its CDL.

    A node is read, asked for what it must refuse, and its communication is reset; it ends in
    PRE-OPERATIONAL with the values that it had. A board gets requests that it must refuse. Nothing
    moves, and no function is called, unless --actuate permits it. Exit code 1: a check has failed.
    """
    from rtgen.cli.conformance.report import as_html, as_json_text, as_junit, as_text

    suffix = file.suffix.lower()
    if suffix in _DESCRIPTIONS:
        report = _node(file, node_id, connect, access, timeout, boot, actuate)
    elif suffix == ".cdl":
        from rtgen.cli.conformance.board import testing

        peer = Peer(*wire, timeout)
        if connect is None:
            raise click.MissingParameter(param_hint="--connect", param_type="option")
        report = testing.tested(
            file, connect, signature, functions, peer, baud=baud, actuate=actuate
        )
    else:
        raise Refusal(f"{file} is not an EDS, a DCF or a CDL file")
    write_out(as_json_text(report) if as_json else as_text(report))
    for path, form in ((junit, as_junit), (html, as_html)):
        if path is not None:
            _write(path, form(report))
    return OK if report.passed else NO


def _node(
    file: Path,
    node_id: int | None,
    connect: str | None,
    access: BusAccess,
    timeout: float,
    boot: float,
    actuate: bool,
) -> Report:
    from rtgen.cli.conformance.canopen.testing import tested

    if connect is not None:
        interface, _, channel = connect.partition(":")
        if not interface or not channel:
            message = f"{connect!r} is not INTERFACE:CHANNEL"
            raise click.BadParameter(message, param_hint="--connect")
        access = replace(access, interface=interface, channel=channel)
    return tested(file, node_id, access, timeout=timeout, boot=boot, actuate=actuate)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error
