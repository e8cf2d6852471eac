"""Converts bus files into DBC files."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.diagnostics import has_errors, in_order
from rtgen.tools.components.conversion import Converted, named, require_form
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import BAD_INPUT, ReportedError

OF_BUSES = ("dbc",)


def converted_bus(console: Console, path: Path, form: str | None) -> Converted:
    """Return the bus of a bus file in a form, a DBC file by default.

    Raises InputError, ReportedError.
    """
    from rtgen.compiler.frontends import bus as front_end
    from rtgen.tools.can.dbc.messages import bus_dbc
    from rtgen.tools.can.decoding.node_index import bus_index

    form = form or OF_BUSES[0]
    require_form(form, OF_BUSES, "a bus")
    read = front_end.load(path, root=Path.cwd())
    if read.bus is None or has_errors(read.diagnostics):
        console.findings(read.diagnostics, read.sources)
        raise ReportedError(BAD_INPUT)
    content, left_out = bus_dbc(read.bus, bus_index(read.bus))
    console.findings(in_order([*read.diagnostics, *left_out]), read.sources)
    return named(read.bus.name, form, content)
