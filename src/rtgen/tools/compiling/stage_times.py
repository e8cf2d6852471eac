"""Table of `-v`: the duration of each stage of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns
from typing import TypeAlias

from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import table

_MIN_NS = 50_000
"""Minimum duration; shorter stages are omitted, since they had nothing to do."""

Path: TypeAlias = tuple[str, ...]
"""A stage's name, preceded by those of the enclosing stages."""


@dataclass(slots=True)
class _Row:
    ns: int = 0
    files: int = 0
    note: str = ""

    def remark(self) -> str:
        files = ""
        if self.files:
            files = translated(f"{self.files} file{'s' * (self.files != 1)}")
        return ", ".join(filter(None, (self.note, files)))


class StageTimes:
    """Sums the durations of each stage, in the order of their first starts.

    `clock` returns the time [ns].
    """

    def __init__(self, clock: Callable[[], int] = perf_counter_ns) -> None:
        self._clock = clock
        self._start = clock()
        self._rows: dict[Path, _Row] = {}
        self._open: list[tuple[str, int]] = []

    def begin(self, stage: str) -> None:
        """See `stages.Observer`."""
        self._open.append((stage, self._clock()))
        self._rows.setdefault(self._path(), _Row())

    def end(self) -> None:
        """See `stages.Observer`."""
        path = self._path()
        _, start = self._open.pop()
        self._rows[path].ns += self._clock() - start

    def file(self, _: str) -> None:
        """See `stages.Observer`."""
        if self._open:
            self._rows[self._path()].files += 1

    def note(self, text: str) -> None:
        """See `stages.Observer`."""
        if self._open:
            self._rows[self._path()].note = text

    def table(self) -> str:
        """Return the stages with their durations in ms, nested stages indented.

        Empty without stages.
        """
        if not self._rows:
            return ""
        lines = [
            ("  " * (len(path) - 1) + translated_word(path[-1]), row.ns, row.remark())
            for path, row in self._rows.items()
            if row.ns >= _MIN_NS
        ]
        lines.append((translated_word("total"), self._clock() - self._start, ""))
        cells = [(translated_word("stage"), "ms", "")]
        cells += [(name, f"{ns / 1e6:.1f}", remark) for name, ns, remark in lines]
        return "\n".join(table(cells, right=(1,)))

    def _path(self) -> Path:
        return tuple(name for name, _ in self._open)
