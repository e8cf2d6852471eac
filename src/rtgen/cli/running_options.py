"""Options of the commands that run systems."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from rtgen.cli.parameter_types import FiniteRange
from rtgen.facts.value_checks import CheckValues
from rtgen.tools.running.failures import FailureOptions
from rtgen.tools.running.live_options import LiveOptions
from rtgen.tools.running.recording_options import RecordingOptions

RATE = FiniteRange(1e-6, 1e6)
"""Type of the options for the factor."""


def with_failures(command: Callable[..., int]) -> Callable[..., int]:
    """Add --traceback, --pdb, -v and --fail-on; the function gets `shown_failures`."""

    @functools.wraps(command)
    def wrapped(
        traceback_form: str, debug: bool, verbose: int, fail_on: str, **kwargs: Any
    ) -> int:
        counted = fail_on == "error"
        options = FailureOptions(traceback_form, debug, verbose, counted)
        return command(shown_failures=options, **kwargs)

    function: Callable[..., int] = wrapped
    for decorate in (
        click.option(
            "--fail-on",
            type=click.Choice(["error", "never"]),
            default="error",
            show_default=True,
            help="Exit code 1 for a component in ERROR at the end, or whose code raised.",
        ),
        click.option(
            "-v",
            "--verbose",
            "verbose",
            count=True,
            help="Print messages of the runtime; -vv: all messages.",
        ),
        click.option(
            "--pdb",
            "debug",
            is_flag=True,
            help="Open the debugger where component code raises; quitting it ends the run.",
        ),
        click.option(
            "--traceback",
            "traceback_form",
            type=click.Choice(["none", "short", "full"]),
            default="short",
            show_default=True,
            help="Traceback of component code that fails; short: its own files only.",
        ),
    ):
        function = decorate(function)
    return function


with_value_checks = click.option(
    "--check-values",
    type=click.Choice([each.value for each in CheckValues]),
    default=CheckValues.FIRST.value,
    show_default=True,
    help="Check values of samples and calls in the process: all, the first and some, or none.",
)


def with_ros2(command: Callable[..., int]) -> Callable[..., int]:
    """Add the option to a command; the function gets it as `ros2`."""

    @click.option(
        "--ros2",
        type=click.Choice(["dds", "zenoh"]),
        help="Map the ports of [ros2.topics] to topics of ROS 2 (real time).",
    )
    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> int:
        return command(*args, **kwargs)

    function: Callable[..., int] = wrapped
    return function


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


def with_live(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options to a command; the function gets them as `live`."""

    @click.option(
        "--foxglove",
        "place",
        is_flag=False,
        flag_value=str(_PORT),
        callback=_place,
        metavar="[[HOST:]PORT]",
        help=f"Serve the run to Foxglove; default: {_LOOPBACK}:{_PORT}; port 0: any free port.",
    )
    @click.option(
        "--rate",
        type=RATE,
        metavar="FACTOR",
        help="Simulated seconds per second; default: as fast as possible.",
    )
    @functools.wraps(command)
    def wrapped(
        *args: Any,
        place: tuple[str, int] | None,
        rate: float | None,
        **kwargs: Any,
    ) -> int:
        return command(*args, live=LiveOptions(place, rate), **kwargs)

    function: Callable[..., int] = wrapped
    return function


def with_recording(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options to a command; the function gets them as `recording`."""

    @click.option(
        "--record",
        "recorded",
        metavar="FILE.mcap",
        help="Record samples, states, parameters, frames and calls of boards as MCAP.",
    )
    @click.option(
        "--compression",
        type=click.Choice(["zstd", "lz4", "none"]),
        help="Compression of --record; default: zstd.",
    )
    @functools.wraps(command)
    def wrapped(
        *args: Any, recorded: str | None, compression: str | None, **kwargs: Any
    ) -> int:
        options = RecordingOptions(recorded, compression)
        return command(*args, recording=options, **kwargs)

    function: Callable[..., int] = wrapped
    return function
