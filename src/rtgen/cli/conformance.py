"""The command `rtgen conformance`: tests a device, board or component against its definition."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from rtgen.cli.conformance_options import with_subject
from rtgen.cli.help import command, grouped
from rtgen.cli.options import with_console
from rtgen.tools.can.access import BusAccess
from rtgen.tools.conformance.subject import Subject
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK
from rtgen.tools.kit.files import save


@command("conformance")
@click.argument(
    "file",
    metavar="[FILE]",
    required=False,
    type=click.Path(dir_okay=False, path_type=Path),
)
@grouped(
    "Results",
    click.option("--json", "as_json", is_flag=True, help="Print JSON."),
    click.option(
        "--junit",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="Also write JUnit XML.",
    ),
    click.option(
        "--html",
        type=click.Path(dir_okay=False, path_type=Path),
        metavar="FILE",
        help="Also write an HTML page.",
    ),
)
@with_subject
@with_console
def conformance(
    console: Console,
    subject: Subject,
    file: Path | None,
    as_json: bool,
    junit: Path | None,
    html: Path | None,
) -> int:
    """Test a CANopen node, a TECS board or a running RT component against its definition.

    FILE is an EDS, DCF, XDD or XDC, a CDL file, or an IDL file or RTC.xml; without it, the
    definition is that in the project's [sources]. Nothing moves, no function is called, and nothing
    is activated or configured unless --actuate permits it. A node ends in PRE-OPERATIONAL with its
    former values. Exit code 1: a check has failed.
    """
    from rtgen.tools.conformance import report as reports
    from rtgen.tools.conformance.testing import is_of_node, tested

    if is_of_node(file, subject.connect):
        subject = replace(subject, access=_on_bus(subject.access, subject.connect))
    elif not subject.connect:
        raise click.MissingParameter(param_hint="--connect", param_type="option")
    report = tested(file, subject, console)
    write_out(reports.as_json_text(report) if as_json else reports.as_text(report))
    for path, form in ((junit, reports.as_junit), (html, reports.as_html)):
        if path is not None:
            save(path, form(report).encode())
    return OK if report.passed else NO


def _on_bus(access: BusAccess, connect: str) -> BusAccess:
    """Return the access to the bus of `--connect`, if it is given. Raises click.BadParameter."""
    if not connect:
        return access
    interface, _, channel = connect.partition(":")
    if not interface or not channel:
        message = f"{connect!r} is not INTERFACE:CHANNEL"
        raise click.BadParameter(message, param_hint="--connect")
    return replace(access, interface=interface, channel=channel)
