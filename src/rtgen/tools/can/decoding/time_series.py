"""Time series of object values, written as CSV or drawn as diagrams."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from rtgen.facts.extras import installation
from rtgen.tools.kit.curve import Curve
from rtgen.tools.kit.exits import Refusal
from rtgen.tools.running.trajectory import (
    PICTURES,
    Results,
    reproducible,
    require_matplotlib,
    save_picture,
)

_WIDTH, _HEIGHT = 9.0, 2.6
"""Width of a picture and height of each of its diagrams, in inches."""


def check_output(path: Path) -> None:
    """Raise Refusal for an unknown suffix, ToolError if matplotlib is missing."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return
    if suffix not in PICTURES:
        raise Refusal(f"{path}: the suffix is one of {', '.join(PICTURES)}, .csv")
    require_matplotlib(suffix, f"{installation('plot')}; or write .csv")


def write_csv(path: Path, curves: Sequence[Curve]) -> None:
    """Write a row for each value and a column for each curve. Raises ToolError."""
    rows = sorted(
        (time, column, value)
        for column, curve in enumerate(curves)
        for time, value in zip(curve.times, curve.values, strict=True)
    )
    with Results(str(path)) as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["t", *(curve.title for curve in curves)])
        for time, column, value in rows:
            cells = [""] * len(curves)
            cells[column] = repr(value)
            writer.writerow([f"{time:.6f}", *cells])


def draw(path: Path, curves: Sequence[Curve]) -> None:
    """Draw one diagram for each unit, above a common time axis. Raises ToolError."""
    from matplotlib.figure import Figure

    units = list(dict.fromkeys(curve.unit for curve in curves))
    with reproducible():
        figure = Figure((_WIDTH, 1.0 + _HEIGHT * len(units)), layout="constrained")
        rows = figure.subplots(len(units), sharex=True, squeeze=False)
        for unit, (axes,) in zip(units, rows, strict=True):
            for curve in curves:
                if curve.unit == unit:
                    # A value holds until the next sample.
                    axes.step(curve.times, curve.values, where="post", label=curve.name)
            axes.set_ylabel(unit or "value")
            axes.grid(visible=True, alpha=0.3)
            axes.legend(loc="best")
        rows[-1][0].set_xlabel("t [s]")
        save_picture(figure, path)
