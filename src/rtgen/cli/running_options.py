"""Options of the commands that run systems."""

from __future__ import annotations

import click

from rtgen.cli.help import gathered, grouped
from rtgen.cli.parameter_types import FiniteRange
from rtgen.facts.threads import Threads
from rtgen.facts.value_checks import CheckValues
from rtgen.tools.recording.mcap_writer import COMPRESSIONS
from rtgen.tools.running.failures import FailureOptions
from rtgen.tools.running.live_options import LiveOptions
from rtgen.tools.running.recording_options import RecordingOptions

RATE = FiniteRange(1e-6, 1e6)
"""Type of the options for the factor."""


def _failures(
    *, traceback_form: str, debug: bool, verbose: int, fail_on: str
) -> FailureOptions:
    return FailureOptions(traceback_form, debug, verbose, fail_on == "error")


with_failures = gathered(
    "shown_failures",
    _failures,
    click.option(
        "--fail-on",
        type=click.Choice(["error", "never"]),
        default="error",
        metavar="WHAT",
        help="Exit code 1 if components fail: error, never.",
    ),
    click.option(
        "--traceback",
        "traceback_form",
        type=click.Choice(["none", "short", "full"]),
        default="short",
        metavar="FORM",
        help="Where component code failed: none, short, full.",
    ),
    click.option(
        "--pdb",
        "debug",
        is_flag=True,
        help="Open the debugger where component code raises.",
    ),
    click.option(
        "-v",
        "--verbose",
        "verbose",
        count=True,
        help="Print messages of the runtime; -vv: all.",
    ),
    title="Failures",
)


with_value_checks = grouped(
    "Failures",
    click.option(
        "--check-values",
        type=click.Choice([each.value for each in CheckValues]),
        default=CheckValues.FIRST.value,
        metavar="WHICH",
        help="Samples, calls to check: always, first, never.",
    ),
)


with_end_of_replay = click.option(
    "--until",
    type=FiniteRange(0, 1e9),
    metavar="SECONDS",
    help="Stop at this time of the recording.",
)


with_clock = click.option(
    "--clock",
    type=click.Choice(["sim", "real"]),
    default="sim",
    help="Simulated time, at full speed, or real time.",
)


with_clock_of_run = click.option(
    "--clock",
    type=click.Choice(["sim", "real", "ros"]),
    default="sim",
    help="Simulated time, real time, or the time of /clock.",
)


_LOOPBACK = "127.0.0.1"
_PORT = 8765
_PORTS = 1 << 16


def _place(
    _: click.Context, __: click.Parameter, value: str | None
) -> tuple[str, int] | None:
    """Validate `PORT` or `HOST:PORT`. Raises click.BadParameter."""
    if value is None:
        return None
    host, _colon, port = value.rpartition(":")
    is_number = port.isascii() and port.isdecimal()
    if is_number and int(port[:6]) >= _PORTS:
        raise click.BadParameter(f"{port} is not a port: they are 0 to {_PORTS - 1}.")
    if not is_number:
        message = (
            f"'{value}' is not PORT or HOST:PORT; a system goes before --foxglove."
        )
        raise click.BadParameter(message)
    return host.strip("[]") or _LOOPBACK, int(port)


with_live = gathered(
    "live",
    LiveOptions,
    click.option(
        "--foxglove",
        "place",
        is_flag=False,
        flag_value=str(_PORT),
        callback=_place,
        metavar="[[HOST:]PORT]",
        help=f"Serve the run to Foxglove, at {_LOOPBACK}:{_PORT}.",
    ),
    click.option(
        "--rate",
        type=RATE,
        metavar="FACTOR",
        help="Simulated seconds per second.",
    ),
    click.option(
        "--threads",
        type=click.Choice([each.value for each in Threads]),
        metavar="WHICH",
        help="In real time: shared (one), or own.",
    ),
    title="Results",
)


with_recording = gathered(
    "recording",
    lambda *, recorded, compression: RecordingOptions(recorded, compression),
    click.option(
        "--record",
        "recorded",
        metavar="FILE.mcap",
        help="Record all events as MCAP; with --ros2, topics as a bag.",
    ),
    click.option(
        "--compression",
        type=click.Choice(COMPRESSIONS),
        metavar="NAME",
        help="Of --record: zstd (default), lz4 or none.",
    ),
    title="Results",
)
