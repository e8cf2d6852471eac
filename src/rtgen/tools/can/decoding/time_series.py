"""Time series of object values, written as CSV or drawn as diagrams."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import TextIOWrapper
from pathlib import Path

from rtgen.compiler.diagnostics import ToolError
from rtgen.facts.extras import installation
from rtgen.facts.files import create_file
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.trajectory import (
    PICTURES,
    reproducible,
    require_matplotlib,
    save_picture,
)

_WIDTH, _HEIGHT = 9.0, 2.6
"""Width of a picture and height of each of its diagrams, in inches."""


class Series:
    """The values of an object, with times in seconds since the first frame."""

    def __init__(self, label: str, unit: str) -> None:
        self.label = label
        self.unit = unit
        self.times: list[float] = []
        self.values: list[int | float] = []

    @property
    def title(self) -> str:
        """The label with its unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def add(self, time: float, value: int | float) -> None:
        """Append a value."""
        self.times.append(time)
        self.values.append(value)


def check_output(path: Path) -> None:
    """Raise Refusal for an unknown suffix, ToolError if matplotlib is missing."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return
    if suffix not in PICTURES:
        raise Refusal(f"{path}: the suffix is one of {', '.join(PICTURES)}, .csv")
    require_matplotlib(suffix, f"{installation('plot')}; or write .csv")


def write_csv(path: Path, curves: Sequence[Series]) -> None:
    """Write a row for each value and a column for each series. Raises ToolError."""
    rows = sorted(
        (time, column, value)
        for column, series in enumerate(curves)
        for time, value in zip(series.times, series.values, strict=True)
    )
    try:
        with TextIOWrapper(create_file(path), encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(["t", *(series.title for series in curves)])
            for time, column, value in rows:
                cells = [""] * len(curves)
                cells[column] = repr(value)
                writer.writerow([f"{time:.6f}", *cells])
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error


def draw(path: Path, curves: Sequence[Series]) -> None:
    """Draw one diagram for each unit, above a common time axis. Raises ToolError."""
    from matplotlib.figure import Figure

    units = list(dict.fromkeys(series.unit for series in curves))
    with reproducible():
        figure = Figure((_WIDTH, 1.0 + _HEIGHT * len(units)), layout="constrained")
        rows = figure.subplots(len(units), sharex=True, squeeze=False)
        for unit, (axes,) in zip(units, rows, strict=True):
            for series in curves:
                if series.unit == unit:
                    # A value holds until the next sample.
                    axes.step(
                        series.times, series.values, where="post", label=series.label
                    )
            axes.set_ylabel(unit or "value")
            axes.grid(visible=True, alpha=0.3)
            axes.legend(loc="best")
        rows[-1][0].set_xlabel("t [s]")
        save_picture(figure, path)
