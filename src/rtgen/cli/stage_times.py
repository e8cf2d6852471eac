"""The table of `-v`: the time that each stage of a run took."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns
from typing import TypeAlias

_LEAST_NS = 50_000
"""Stages that took less are left out: they had nothing to do."""

_TOTAL = "total"

Path: TypeAlias = tuple[str, ...]
"""A stage's name after those of the stages around it."""


@dataclass(slots=True)
class _Row:
    ns: int = 0
    files: int = 0
    note: str = ""

    def remark(self) -> str:
        files = f"{self.files} file{'s' * (self.files != 1)}" if self.files else ""
        return ", ".join(filter(None, (self.note, files)))


class StageTimes:
    """Adds up the time of each stage, in the order in which they first began.

    `clock` gives the time [ns].
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
        """Return the stages with their times in ms, a stage's own stages indented below it.

        Empty if there was no stage.
        """
        if not self._rows:
            return ""
        lines = [
            ("  " * (len(path) - 1) + path[-1], row.ns, row.remark())
            for path, row in self._rows.items()
            if row.ns >= _LEAST_NS
        ]
        lines.append((_TOTAL, self._clock() - self._start, ""))
        cells = [("stage", "ms", "")]
        cells += [(name, f"{ns / 1e6:.1f}", remark) for name, ns, remark in lines]
        left, right = (max(len(row[i]) for row in cells) for i in (0, 1))
        return "\n".join(
            f"{name:<{left}}  {ms:>{right}}  {remark}".rstrip()
            for name, ms, remark in cells
        )

    def _path(self) -> Path:
        return tuple(name for name, _ in self._open)
