"""Displays the progress of a run: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import Protocol

from rtgen.compiler.diagnostics.printable import printable
from rtgen.runtime.timing.clocks import SECOND

_LINE_EVERY = 10 * SECOND


class Progress(Protocol):
    """Observer of the time in ns since the start, and of changes of components' states."""

    def at(self, time: int) -> None:
        """Called as time passes."""

    def state(self, time: int, instance: str, state: str) -> None:
        """Called when a component has changed its state."""


class Silence:
    """Displays nothing."""

    def at(self, time: int) -> None:
        """Do nothing."""

    def state(self, time: int, instance: str, state: str) -> None:
        """Do nothing."""


class Lines:
    """Prints a line for every change of state and for every ten seconds."""

    def __init__(self) -> None:
        self._next = _LINE_EVERY

    def at(self, time: int) -> None:
        """Print a line if ten seconds have passed."""
        if time >= self._next:
            self._next += _LINE_EVERY
            sys.stderr.write(f"{time / SECOND:.0f} s\n")

    def state(self, time: int, instance: str, state: str) -> None:
        """Print the change of state."""
        text = printable(f"{instance} {state}")
        sys.stderr.write(f"{time / SECOND:.3f} s: {text}\n")


class Bar:
    """A progress bar with the latest change of state."""

    def __init__(self, files: ExitStack, limit: int | None) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

        columns = (
            SpinnerColumn("line"),
            BarColumn(),
            TextColumn("{task.fields[time]:8.1f} s"),
            TextColumn("{task.description}", markup=False),
        )
        bar = Progress(*columns, console=Console(stderr=True), transient=True)
        self._progress = files.enter_context(bar)
        self._limit = limit
        total = None if limit is None else limit / SECOND
        self._task = self._progress.add_task("", total=total, time=0.0)

    def at(self, time: int) -> None:
        """Advance the bar."""
        self._progress.update(self._task, completed=time / SECOND, time=time / SECOND)

    def state(self, time: int, instance: str, state: str) -> None:
        """Show the change of state beside the bar."""
        self._progress.update(self._task, description=printable(f"{instance} {state}"))


def progress(files: ExitStack, limit: int | None, *, quiet: bool) -> Progress:
    """Return the display suitable for standard error; `files` closes it."""
    if quiet:
        return Silence()
    return Bar(files, limit) if sys.stderr.isatty() else Lines()
