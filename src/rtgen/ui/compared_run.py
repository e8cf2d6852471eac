"""A run to compare with the current one: a recording, or the same system before a restart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec

from rtgen.runtime.marshalling.descriptors import Descriptor
from rtgen.ui.buses import DescriberOf
from rtgen.ui.channels import Channels
from rtgen.ui.history import History
from rtgen.ui.protocol import ui
from rtgen.ui.reading import MAX_OCTETS, Reading
from rtgen.ui.type_table import TypeTable

_BEFORE: Final = "the run before"
"""The name of a kept run, which is compared with the next one."""
_PART: Final = 60.0
"""Maximum time that is reported at once [s]."""


class ComparedRun(msgspec.Struct, eq=False):
    """A run whose samples and changes of state are reported at their times in the current run."""

    name: str
    _history: History
    channels: Mapping[int, ui.Channel]
    """The channels for pages, by their numbers in the history."""
    _descriptors: Mapping[int, Descriptor] = {}

    _reported: float = -math.inf

    def enter_types(self, types: TypeTable) -> None:
        """Give the channels of a recording the numbers of their types in a table."""
        for each in self.channels.values():
            each.type_number = types.number(self._descriptors.get(each.id))

    def begin(self) -> None:
        """Restart the reporting from the beginning of the other run."""
        self._reported = -math.inf

    def until(self, time: float) -> tuple[list[ui.Event], list[ui.Sample]]:
        """Return the changes of state and samples from the last call up to a time, exclusive.

        Of a long time, only the next part.
        """
        start = self._reported
        self._reported = max(min(time, max(start, 0.0) + _PART), start)
        changes = self._history.changes_between(start, self._reported)
        samples = self._history.samples_between(start, self._reported, self.channels)
        return [*_as_other_run(changes)], [
            ui.Sample(self.channels[each.channel].id, each.time, each.data)
            for each in samples
        ]


class Comparison:
    """The run that pages compare with this one, if any: a recording, or the run before."""

    def __init__(self, recording: ComparedRun | None) -> None:
        self.run = self._recording = recording
        self.keeps = False
        """Whether this run is kept for comparison when time is set back."""

    @property
    def name(self) -> str:
        """The name of the compared run; empty without one."""
        return "" if self.run is None else self.run.name

    @property
    def channels(self) -> list[ui.Channel]:
        """The channels of the compared run."""
        return [] if self.run is None else [*self.run.channels.values()]

    def take(self, recording: ComparedRun | None) -> None:
        """Compare a recording with this run and the next ones, or nothing."""
        self.run = self._recording = recording
        self.keeps = False

    def keep(self, *, kept: bool) -> None:
        """Set whether this run is kept for comparison when time is set back."""
        self.keeps = kept
        if not kept or self.run is self._recording:
            self.run = self._recording = None

    def open(self) -> None:
        """Compare runs of another system with the recording alone."""
        self.keeps, self.run = False, self._recording

    def end(self, history: History, channels: Channels) -> None:
        """Compare the next run with the one that ends, if that is to be kept."""
        if self.keeps and self.run is None:
            self.run = _kept(history, channels)


def _as_other_run(changes: Sequence[ui.Event]) -> Iterator[ui.Event]:
    for event in changes:
        if event.discriminator is ui.EventKind.EVENT_STATE:
            yield ui.Event.of_other(event.change)
        elif event.discriminator is ui.EventKind.EVENT_BESIDE:
            yield event


def read(file: str, numbers: Iterator[int], describer: DescriberOf) -> ComparedRun:
    """Read a recording, from any thread; `enter_types` follows. Raises ToolError."""
    reading = Reading(
        History(MAX_OCTETS), TypeTable(), numbers, describer, lambda _: None
    )
    reading.read(file, beside=True)
    channels = {each.id: each for each in reading.channels}
    return ComparedRun(Path(file).name, reading.history, channels, reading.descriptors)


def _kept(history: History, channels: Channels) -> ComparedRun:
    """Return the previous run of the same system, whose channels get new numbers."""
    return ComparedRun(
        _BEFORE,
        history,
        {
            each.id: ui.Channel(
                next(channels.numbers), each.port, each.type_number, True
            )
            for each in [*channels.values()]
            if not each.beside
        },
    )
