"""Options of commands that show a running system."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import click

from rtgen import runtime
from rtgen.cli.common import Console, Refusal
from rtgen.cli.running.pace import RATE, pace
from rtgen.diagnostics import ToolError

_LOOPBACK = "127.0.0.1"
_PORT = 8765
_PORTS = 1 << 16


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """Address for clients of a live view, and the pace of simulated time."""

    place: tuple[str, int] | None
    rate: float | None

    def begin(
        self, files: ExitStack, running: runtime.System, console: Console, name: str
    ) -> None:
        """Show a system until `files` is closed, at its pace. Raises ToolError."""
        simulated = isinstance(running.clock, runtime.SimulatedClock)
        if self.rate is not None and not simulated:
            raise Refusal("--rate goes with --clock sim")
        if self.place is not None:
            from rtgen.recording.errors import RecordingError
            from rtgen.recording.live_view import LiveView

            try:
                view = LiveView(running, name, *self.place)
            except RecordingError as error:
                raise ToolError(str(error), hint=error.hint) from error
            files.callback(view.close)
            console.say(f"Foxglove: {view.address}")
        if self.rate is not None:
            pace(running, self.rate)


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
