"""Options of commands that show a running system."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from rtgen import runtime
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.pace import pace


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """Address for clients of a live view, the pace of simulated time, the threads of real time."""

    place: tuple[str, int] | None = None
    rate: float | None = None
    threads: str | None = None

    def begin(
        self,
        files: ExitStack,
        running: runtime.System,
        console: Console,
        name: str,
        rest: Callable[[float], None] = time.sleep,
    ) -> None:
        """Show a system until `files` is closed, at its pace; `rest` waits. Raises ToolError."""
        simulated = isinstance(running.clock, runtime.SimulatedClock)
        if self.rate is not None and not simulated:
            raise Refusal("--rate goes with --clock sim")
        if self.threads is not None and simulated:
            raise Refusal(
                "--threads goes with --clock real: simulated time has no threads"
            )
        if self.place is not None:
            from rtgen.tools.recording.live_view import LiveView

            view = LiveView(running, name, *self.place)
            files.callback(view.close)
            console.say(f"Foxglove: {view.address}")
        if self.rate is not None:
            pace(running, self.rate, rest)
