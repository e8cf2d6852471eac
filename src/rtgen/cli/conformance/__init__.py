"""The command `rtgen conformance`: tests a device, board or component against its definition."""

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
from rtgen.facts.idl_files import IDL_SUFFIXES
from rtgen.files import create_file
from rtgen.runtime.opaque_rpc.serial import BAUDRATE

if TYPE_CHECKING:
    from collections.abc import Collection

    from rtgen.cli.conformance.check import Permission
    from rtgen.cli.conformance.report import Report

_DESCRIPTIONS = (".eds", ".dcf")
_COMPONENTS = (*IDL_SUFFIXES, ".xml", ".yaml", ".yml")


@click.command("conformance")
@click.argument("file", metavar="FILE", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--connect",
    metavar="WAY:WHERE",
    help="tcp:HOST:PORT or serial:DEVICE of a board; HOST[:PORT]/NAME.rtc, corbaname: or the "
    "like of a component; or a bus in one word, such as socketcan:can0, for --interface and "
    "--channel.",
)
@click.option(
    "--node",
    "node_id",
    type=WholeRange(1, 127),
    metavar="NODE-ID",
    help="Node-id; default: that of a DCF.",
)
@click.option(
    "--actuate",
    is_flag=True,
    help="Also run checks that may move something: OPERATIONAL, writes to the application, "
    "calls of functions, activation and configuration of components.",
)
@click.option(
    "--defaults",
    is_flag=True,
    help="Compare values with the defaults of the definition, if none was changed on purpose.",
)
@click.option(
    "--exit",
    "may_exit",
    is_flag=True,
    help="Call exit of the component at the end.",
)
@click.option(
    "--signature",
    metavar="SIG",
    help="Signature of the board, if FILE has several.",
)
@click.option(
    "--function",
    "functions",
    multiple=True,
    metavar="NAME",
    help="Call only this function of the board; may be repeated.",
)
@click.option(
    "--component",
    metavar="NAME",
    help="Name of the component, if FILE defines several.",
)
@click.option(
    "-I",
    "include",
    multiple=True,
    metavar="DIR",
    help="Search DIR for types of a component's ports.",
)
@click.option(
    "--baud",
    type=WholeRange(min=1),
    default=BAUDRATE,
    show_default=True,
    help="Baud rate of a serial line.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--junit",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Also write JUnit XML to a file.",
)
@click.option(
    "--html",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Also write an HTML page to a file.",
)
@click.option(
    "--timeout",
    type=FiniteRange(min=0.01),
    default=1.0,
    show_default=True,
    metavar="S",
    help="Seconds to wait for a response of the node, board or component.",
)
@click.option(
    "--boot",
    type=FiniteRange(min=0.01),
    default=5.0,
    show_default=True,
    metavar="S",
    help="Seconds to wait for the boot-up of the node.",
)
@click.option(
    "--stall",
    type=FiniteRange(min=0.01),
    metavar="S",
    help="Seconds after which the board must disconnect a client that stalls in a request.",
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
    defaults: bool,
    may_exit: bool,
    signature: str | None,
    functions: tuple[str, ...],
    component: str | None,
    include: tuple[str, ...],
    baud: int,
    as_json: bool,
    junit: Path | None,
    html: Path | None,
    timeout: float,
    boot: float,
    stall: float | None,
) -> int:
    """Test a CANopen node against its EDS or DCF, a TECS board against its CDL, or a running RT
    component against its IDL or RTC.xml.

    A node is read, gets requests that it must refuse, and its communication is reset; it ends in
    PRE-OPERATIONAL with its former values. A board gets requests that it must refuse, and the
    profile of a component is read. Nothing moves, no function is called, and nothing is activated
    or configured unless --actuate permits it. Exit code 1: a check has failed.
    """
    from rtgen.cli.conformance.report import as_html, as_json_text, as_junit, as_text

    permissions = _permissions(actuate, defaults, may_exit)
    suffix = file.suffix.lower()
    if suffix in _DESCRIPTIONS:
        report = _node(file, node_id, connect, access, timeout, boot, permissions)
    elif suffix == ".cdl":
        from rtgen.cli.conformance.board import testing

        peer = Peer(wire, timeout)
        if connect is None:
            raise click.MissingParameter(param_hint="--connect", param_type="option")
        report = testing.tested(
            file,
            connect,
            signature,
            functions,
            peer,
            baud=baud,
            stall=stall,
            permissions=permissions,
        )
    elif suffix in _COMPONENTS:
        report = _component(file, component, include, connect, timeout, permissions)
    else:
        raise Refusal(
            f"{file} is not an EDS, a DCF, a CDL file or the definition of a component"
        )
    write_out(as_json_text(report) if as_json else as_text(report))
    for path, form in ((junit, as_junit), (html, as_html)):
        if path is not None:
            _write(path, form(report))
    return OK if report.passed else NO


def _permissions(
    actuate: bool, defaults: bool, may_exit: bool
) -> Collection[Permission]:
    from rtgen.cli.conformance.check import Permission

    given = {
        Permission.ACTUATE: actuate,
        Permission.DEFAULTS: defaults,
        Permission.EXIT: may_exit,
    }
    return [permission for permission, is_given in given.items() if is_given]


def _node(
    file: Path,
    node_id: int | None,
    connect: str | None,
    access: BusAccess,
    timeout: float,
    boot: float,
    permissions: Collection[Permission],
) -> Report:
    from rtgen.cli.conformance.canopen.testing import tested

    if connect is not None:
        interface, _, channel = connect.partition(":")
        if not interface or not channel:
            message = f"{connect!r} is not INTERFACE:CHANNEL"
            raise click.BadParameter(message, param_hint="--connect")
        access = replace(access, interface=interface, channel=channel)
    return tested(
        file, node_id, access, timeout=timeout, boot=boot, permissions=permissions
    )


def _component(
    file: Path,
    name: str | None,
    include: tuple[str, ...],
    connect: str | None,
    timeout: float,
    permissions: Collection[Permission],
) -> Report:
    if connect is None:
        raise click.MissingParameter(param_hint="--connect", param_type="option")
    try:
        from rtgen.cli.conformance.rtc.testing import tested
    except ImportError as error:
        raise ToolError(
            "a test of a component needs omniORBpy, which is not installed",
            hint="pip install 'rtgen[corba]'",
        ) from error
    return tested(
        file, connect, name, include, timeout=timeout, permissions=permissions
    )


def _write(path: Path, text: str) -> None:
    try:
        with create_file(path) as stream:
            stream.write(text.encode())
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error
