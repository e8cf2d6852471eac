"""The command `rtgen can timing`: bus load and worst-case response times."""

from __future__ import annotations

import json
from pathlib import Path

import click
from msgspec.structs import replace

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.run_table import with_run_table
from rtgen.compiler.backends.canopen.reports import timing_text
from rtgen.compiler.kit.translation import translated_word
from rtgen.compiler.layouts.can_messages import messages
from rtgen.compiler.layouts.can_timing import Timing, load, response_times
from rtgen.compiler.model.canopen import BIT_RATES
from rtgen.tools.can.project_bus import listed, project_buses, require_bus_file
from rtgen.tools.can.writing_rates import writings
from rtgen.tools.kit.console import Console, write_out, write_text
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK
from rtgen.tools.running.plan import read_system


@command("timing")
@with_console
@with_run_table(system="system")
@click.argument(
    "file",
    metavar="[BUS.toml]",
    required=False,
    type=click.Path(dir_okay=False, path_type=Path),
)
@click.option(
    "--bit-rate",
    type=click.Choice([str(rate) for rate in BIT_RATES]),
    help="Calculate for another bit rate, in kbit/s.",
)
@click.option(
    "--system",
    type=click.Path(exists=True),
    metavar="FILE",
    help="Use the rates at which its components write to the proxies.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def timing_(
    console: Console,
    file: Path | None,
    bit_rate: str | None,
    system: str | None,
    as_json: bool,
) -> int:
    """Calculate the load of a bus, and the worst-case response time of each message.

    The analysis follows Davis, Burns, Bril and Lukkien (2007), with the maximum number of stuff
    bits, and one queue for the messages of the manager and the proxies. Exit code 1: a message has
    no bound, or can be later than its next instance.
    """
    from rtgen.compiler.frontends import bus as front_end

    if file is None:
        buses = project_buses(console)
        if len(buses) != 1:
            of = f"one of {listed(buses)}" if buses else "no bus file is in [sources]"
            raise click.UsageError(f"Missing argument 'BUS.toml': {of}.")
        [file] = buses
    require_bus_file(file)
    result = front_end.load(file, root=Path.cwd())
    console.findings(result.diagnostics, result.sources)
    if result.bus is None:
        return BAD_INPUT
    bus = replace(result.bus, bit_rate=int(bit_rate or result.bus.bit_rate))
    rates = None
    if system is not None:
        rates = writings(bus, read_system(system, console))
    traffic = messages(bus, rates)
    timings = list(response_times(traffic, bus.bit_rate))
    if as_json:
        document = {
            "bus": bus.name,
            "bit_rate": bus.bit_rate,
            "load": load(traffic, bus.bit_rate),
            "messages": [_json(timing) for timing in timings],
        }
        write_out(f"{json.dumps(document)}\n")
    else:
        text = timing_text(bus, (), rates, said=translated_word)
        write_text(text.lstrip("\n"))
    return NO if any(t.response is None or _is_late(t) for t in timings) else OK


def _is_late(timing: Timing) -> bool:
    """Return whether a message can still be queued when its next instance is due."""
    return timing.response is not None and timing.response > timing.message.period


def _json(timing: Timing) -> dict[str, object]:
    message = timing.message
    return {
        "name": message.name,
        "id": message.identifier,
        "extended": message.extended,
        "octets": message.octets,
        "period_ns": message.period,
        "frame_ns": timing.transmission,
        "response_ns": timing.response,
    }
