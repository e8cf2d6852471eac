"""Shows the stages of a run: their durations, and progress on a terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

import msgspec

from rtgen.compiler.kit import stages
from rtgen.tools.kit.console import Console

LONG_S = 1.0
"""Duration of work after which its progress is shown [s]."""


@contextmanager
def shown(console: Console) -> Iterator[None]:
    """Show progress of stages within the block, and their durations afterwards if requested."""
    with ExitStack() as stack:
        observers: list[stages.Observer] = []
        if console.verbose:
            from rtgen.tools.compiling.stage_times import StageTimes

            times = StageTimes()
            observers.append(times)
            stack.callback(lambda: console.say(times.table()))
        if _shows_progress(console):
            from rtgen.tools.compiling.stage_progress import StageProgress

            progress = StageProgress(LONG_S)
            observers.append(progress)
            stack.callback(progress.close)
        if observers:
            stack.enter_context(stages.observed(_All(observers)))
        yield


class _All(msgspec.Struct, frozen=True):
    """Several observers."""

    observers: Sequence[stages.Observer]

    def begin(self, stage: str) -> None:
        for each in self.observers:
            each.begin(stage)

    def end(self) -> None:
        for each in self.observers:
            each.end()

    def file(self, name: str) -> None:
        for each in self.observers:
            each.file(name)

    def note(self, text: str) -> None:
        for each in self.observers:
            each.note(text)


def _shows_progress(console: Console) -> bool:
    """Return whether to show progress: standard error is a terminal, not a CI log."""
    plain = os.environ.get("CI") or os.environ.get("TERM") == "dumb"
    talks = console.form == "text" and not console.quiet
    return talks and not plain and sys.stderr.isatty()
