"""The command `rtgen conformance`: tests a device, board or component against its definition."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from rtgen.cli.can.options import with_bus
from rtgen.cli.options import with_console
from rtgen.cli.parameter_types import FiniteRange, WholeRange
from rtgen.cli.rpc.common import with_representation
from rtgen.runtime.opaque_rpc.serial import BAUDRATE
from rtgen.tools.can.access import BusAccess
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.kit.files import save
from rtgen.tools.rpc.signatures import Wire


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
    from rtgen.tools.conformance import report as reports
    from rtgen.tools.conformance.check import Permission
    from rtgen.tools.conformance.testing import Subject, require_kind, tested

    if require_kind(file):
        access = _on_bus(access, connect)
    elif connect is None:
        raise click.MissingParameter(param_hint="--connect", param_type="option")
    permissions = {
        Permission.ACTUATE: actuate,
        Permission.DEFAULTS: defaults,
        Permission.EXIT: may_exit,
    }
    subject = Subject(
        connect=connect or "",
        access=access,
        node_id=node_id,
        signature=signature,
        functions=functions,
        wire=wire,
        baud=baud,
        stall=stall,
        component=component,
        include=include,
        timeout=timeout,
        boot=boot,
        permissions=[each for each, is_given in permissions.items() if is_given],
    )
    report = tested(file, subject)
    write_out(reports.as_json_text(report) if as_json else reports.as_text(report))
    for path, form in ((junit, reports.as_junit), (html, reports.as_html)):
        if path is not None:
            save(path, form(report).encode())
    return OK if report.passed else NO


def _on_bus(access: BusAccess, connect: str | None) -> BusAccess:
    """Return the access to the bus of `--connect`, if it is given. Raises click.BadParameter."""
    if connect is None:
        return access
    interface, _, channel = connect.partition(":")
    if not interface or not channel:
        message = f"{connect!r} is not INTERFACE:CHANNEL"
        raise click.BadParameter(message, param_hint="--connect")
    return replace(access, interface=interface, channel=channel)
