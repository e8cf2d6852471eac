"""Pictures of the plane, drawn with matplotlib; the same input gives the same picture."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from math import cos, sin
from pathlib import Path
from typing import Any

from refnav.geometry import Pose

KINDS = (".svg", ".png", ".pdf")
MAX_TRAIL = 100_000
"""Maximum number of poses of a trail; the oldest are dropped."""
ARROW = 0.4
"""Length of the arrow of a pose [m]."""

Point = tuple[float, float]


class PictureError(Exception):
    """A picture that cannot be drawn or written."""


class Picture:
    """A drawing for a file; coordinates in m, colours of matplotlib, drawn in order of the calls.

    Raises PictureError for an unknown kind of file, or without matplotlib.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() not in KINDS:
            raise PictureError(
                f"{path.name} is not a picture; one of {', '.join(KINDS)}"
            )
        if find_spec("matplotlib") is None:
            raise PictureError("a picture needs matplotlib: the extra plot of rtgen")
        self._path = path
        self._items: list[tuple[str, Any, str, str]] = []

    def line(self, points: Sequence[Point], colour: str, name: str = "") -> None:
        """Draw a line through points; its name appears in the legend."""
        self._items.append(("line", list(points), colour, name))

    def points(self, points: Sequence[Point], colour: str, name: str = "") -> None:
        """Draw dots."""
        self._items.append(("points", list(points), colour, name))

    def arrow(self, pose: Pose, colour: str, name: str = "") -> None:
        """Draw a pose as an arrow."""
        self._items.append(("arrow", pose, colour, name))

    def label(self, x: float, y: float, text: str) -> None:
        """Draw a word at a point."""
        self._items.append(("label", (x, y, text), "0.3", ""))

    def save(self, title: str) -> None:
        """Write the picture and start an empty one. Raises PictureError."""
        from matplotlib import rc_context
        from matplotlib.figure import Figure

        with rc_context({"svg.hashsalt": "rtgen", "font.family": "DejaVu Sans"}):
            figure = Figure(figsize=(7.0, 7.6), layout="constrained")
            axes = figure.add_subplot()
            for kind, what, colour, name in self._items:
                label = name or None
                if kind == "line":
                    axes.plot(*_columns(what), color=colour, label=label)
                elif kind == "points":
                    axes.plot(
                        *_columns(what),
                        ".",
                        color=colour,
                        label=label,
                        ms=3,
                        rasterized=True,
                    )
                elif kind == "arrow":
                    x, y, theta = what
                    axes.annotate(
                        "",
                        (x + ARROW * cos(theta), y + ARROW * sin(theta)),
                        (x, y),
                        arrowprops={"color": colour, "arrowstyle": "->"},
                    )
                    axes.plot([x], [y], "o", color=colour, label=label)
                else:
                    axes.annotate(
                        what[2],
                        what[:2],
                        xytext=(5, 5),
                        textcoords="offset points",
                        color=colour,
                        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1},
                    )
            axes.set_aspect("equal", adjustable="datalim")
            axes.set_xlabel("x [m]")
            axes.set_ylabel("y [m]")
            axes.set_title(title)
            axes.grid(visible=True, alpha=0.3)
            if any(name for *_, name in self._items):
                figure.legend(loc="outside lower center", ncols=4)
            kind = self._path.suffix.lower()[1:]
            undated: dict[str, Any] = {
                "pdf": {"CreationDate": None},
                "svg": {"Date": None},
            }
            try:
                figure.savefig(self._path, format=kind, metadata=undated.get(kind))
            except OSError as error:
                raise PictureError(
                    f"cannot write {self._path.name}: {error.strerror}"
                ) from error
        self._items.clear()


def _columns(points: Sequence[Point]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]
