"""`rtgen can timing`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from rtgen.cli.common import BAD_INPUT, NO, OK, Console, with_console, write_out
from rtgen.layouts.can_messages import messages
from rtgen.layouts.can_timing import Timing, load, response_times

_BIT_RATES = (10, 20, 50, 100, 125, 250, 500, 800, 1000)


@click.command("timing")
@click.argument(
    "file", metavar="BUS.toml", type=click.Path(dir_okay=False, path_type=Path)
)
@click.option(
    "--bit-rate",
    type=click.Choice([str(rate) for rate in _BIT_RATES]),
    help="Work it out for another bit rate, in kbit/s.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@with_console
def timing_(console: Console, file: Path, bit_rate: str | None, as_json: bool) -> int:
    """Tell the load of a bus, and how late each of its messages can be in the worst case.

    After Davis, Burns, Bril and Lukkien (2007), with the worst number of stuff bits. Exit code 1: a
    message has no bound, or can be later than the next one of it.
    """
    from rtgen.frontends import bus as front_end

    result = front_end.load(file, root=Path.cwd())
    console.findings(result.diagnostics, result.sources)
    if result.bus is None:
        return BAD_INPUT
    rate = int(bit_rate) if bit_rate else result.bus.bit_rate
    found = messages(result.bus)
    share = load(found, rate)
    timings = list(response_times(found, rate))
    if as_json:
        told = {
            "bus": result.bus.name,
            "bit_rate": rate,
            "load": share,
            "messages": [_json(timing) for timing in timings],
        }
        write_out(f"{json.dumps(told)}\n")
    else:
        write_out(f"load {100 * share:.1f} % of {rate} kbit/s\n")
        _table(timings)
    return NO if any(_is_late(t) or t.response is None for t in timings) else OK


def _is_late(timing: Timing) -> bool:
    """Whether a message can still wait when the next one of it is due."""
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


def _table(timings: list[Timing]) -> None:
    width = max((len(t.message.name) for t in timings), default=0)
    head = f"{'id':>8}  {'message':<{width}}  octets  period [ms]  frame [us]"
    write_out(f"{head}  worst response [us]\n")
    for timing in timings:
        message = timing.message
        digits = 8 if message.extended else 3
        response = "no bound"
        if timing.response is not None:
            response = f"{timing.response / 1000:.0f}"
        if _is_late(timing):
            response += " > period"
        write_out(
            f"{f'{message.identifier:0{digits}X}':>8}  {message.name:<{width}}  "
            f"{message.octets:>6}  {message.period / 1e6:>11.3f}  "
            f"{timing.transmission / 1000:>10.0f}  {response:>19}\n"
        )
