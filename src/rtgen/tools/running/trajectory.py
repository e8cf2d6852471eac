"""Writes the trajectory of a run as CSV and as a picture."""

from __future__ import annotations

import csv
import io
import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeAlias

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.diagnostics.printable import printable
from rtgen.facts.extras import installation
from rtgen.facts.files import check_output, create_file, make_folder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Pose: TypeAlias = tuple[float, float, float]
"""x [m], y [m], heading [rad]."""

CSV_HEADER = ("t", "x", "y", "theta", "goal_x", "goal_y", "goal_theta")
CSV_HEADER_OF_SEVERAL = ("t", "robot", "x", "y", "theta")
PICTURES = (".svg", ".png", ".pdf")
_NO_POSE = ("", "", "")
_ARROW = 0.06


@dataclass(frozen=True, slots=True)
class Sample:
    """Poses of the robots and the goal, `t` seconds after the start."""

    t: float
    poses: tuple[Pose, ...]
    goal: Pose | None = None


class Results(io.TextIOWrapper):
    """A file that is written during a run. The methods raise ToolError with the file's name."""

    def __init__(self, path: str) -> None:
        self._path = path
        with self._failing():
            super().__init__(create_file(Path(path)), encoding="utf-8", newline="")

    def write(self, text: str) -> int:
        """See `io.TextIOBase`."""
        try:
            return super().write(text)
        except OSError as error:
            raise self._failure(error) from error

    def close(self) -> None:
        """See `io.IOBase`."""
        with self._failing():
            super().close()

    @contextmanager
    def _failing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> ToolError:
        return ToolError(f"cannot write {self._path}: {error.strerror}")


def opened(files: ExitStack, path: str | None) -> TextIO | None:
    """Open a file for writing before a run starts; `files` closes it. Raises ToolError."""
    return None if path is None else files.enter_context(Results(path))


def check_picture(path: str | None, command: str = "--plot") -> None:
    """Raise ToolError for an unknown kind of picture, or without matplotlib.

    `command` is the option or command that draws.
    """
    if path is None:
        return
    file = Path(path)
    if file.suffix.lower() not in PICTURES:
        raise ToolError(
            f"cannot draw {path}: unknown kind of picture",
            hint=f"one of {', '.join(PICTURES)}",
        )
    require_matplotlib(command)
    _check_writable(file, pipes=False)


def check_writable(*paths: str | None) -> None:
    """Raise ToolError if one of the files cannot be created or written; contents stay."""
    for path in filter(None, paths):
        _check_writable(Path(path), pipes=True)


def _check_writable(file: Path, *, pipes: bool) -> None:
    try:
        check_output(file, pipes=pipes)
        existed = file.exists()
        if existed and not (file.is_file() or file.is_dir()):
            return  # a pipe can be opened once
        make_folder(file.parent)
        with file.open("ab"):
            pass
        if not existed:
            file.unlink()  # a failed run leaves no empty file
    except OSError as error:
        raise ToolError(f"cannot write {file}: {error.strerror}") from error


def require_matplotlib(user: str, hint: str = installation("plot")) -> None:
    """Raise ToolError if matplotlib is missing, or rejects its environment (MPLBACKEND).

    `user` is the option or format that draws, `hint` is for a missing matplotlib.
    """
    if find_spec("matplotlib") is None:
        raise ToolError(f"{user} needs matplotlib, which is not installed", hint=hint)
    try:
        import_module("matplotlib")
    except ValueError as error:
        raise ToolError(
            f"matplotlib cannot be imported: {error}",
            hint="correct the environment variable MPLBACKEND, or unset it",
        ) from error


def write_csv(stream: TextIO, robots: Sequence[str], samples: Sequence[Sample]) -> None:
    """Write one line for each sample and robot, after a header.

    A single robot is written with its goal, whose columns are empty before the first goal;
    several robots are written with their names.
    """
    writer = csv.writer(stream, lineterminator="\n")
    if len(robots) == 1:
        writer.writerow(CSV_HEADER)
        writer.writerows((s.t, *s.poses[0], *(s.goal or _NO_POSE)) for s in samples)
        return
    writer.writerow(CSV_HEADER_OF_SEVERAL)
    writer.writerows(
        (s.t, robot, *pose)
        for s in samples
        for robot, pose in zip(robots, s.poses, strict=True)
    )


def draw(
    path: str, title: str, robots: Sequence[str], samples: Sequence[Sample]
) -> None:
    """Draw the trajectories with starts, ends, goals, heading arrows and equal axes."""
    from matplotlib.figure import Figure

    with reproducible():
        figure = Figure(figsize=(7.0, 7.6), layout="constrained")
        axes = figure.add_subplot()
        draw_trajectories(axes, robots, samples)
        axes.set_title(title)
        add_legend(figure, [axes])
        save_picture(figure, Path(path))


@contextmanager
def reproducible() -> Iterator[None]:
    """Make matplotlib's output deterministic, and names not formulas, within the block.

    Some scripts are missing in the font; their characters are shown as boxes.
    """
    from matplotlib import rc_context

    with (
        rc_context(
            {
                "svg.hashsalt": "rtgen",
                "font.family": "DejaVu Sans",
                "text.parse_math": False,
            }
        ),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from")
        yield


_STROKES = (("-", 4.5, 0.45), ("-", 1.4, 1.0), ("--", 1.8, 1.0), (":", 2.4, 1.0))
"""Style, width and opacity by number; overlapping lines stay visible."""


def stroke(number: int, count: int) -> dict[str, Any]:
    """Colour and line style of line `number` of `count` in one diagram."""
    style, width, alpha = ("-", 1.8, 1.0)
    if count > 1:
        style, width, alpha = _STROKES[number % len(_STROKES)]
    return {
        "color": f"C{number % 10}",
        "linestyle": style,
        "linewidth": width,
        "alpha": alpha,
    }


def add_legend(figure: Figure, axes: Sequence[Axes], most: int = 4) -> None:
    """Add one legend below all axes, with up to `most` entries per row."""
    labels: dict[str, Any] = {}
    for each in axes:
        for handle, label in zip(*each.get_legend_handles_labels(), strict=True):
            labels.setdefault(label, handle)
    if labels:
        columns = min(most, len(labels))
        figure.legend(
            labels.values(), labels.keys(), loc="outside lower center", ncols=columns
        )


def draw_trajectories(
    axes: Axes, robots: Sequence[str], samples: Sequence[Sample]
) -> None:
    """Draw the trajectories: a hollow square at each start, a dot at each end."""
    goals = list(dict.fromkeys(s.goal for s in samples if s.goal is not None))
    everywhere = [*goals, *(pose for s in samples for pose in s.poses)]
    scale = _ARROW * max(_extent(everywhere), 0.5)
    alone = len(robots) == 1
    _mark(axes, goals, "tab:red", "goal", scale, marker="o", size=14)
    for number, robot in enumerate(robots):
        line = stroke(number, len(robots))
        poses = [s.poses[number] for s in samples]
        axes.plot(
            [p[0] for p in poses],
            [p[1] for p in poses],
            **line,
            label="robot" if alone else robot,
        )
        _mark(axes, poses[:1], line["color"], "", scale, marker="s", size=9)
        _mark(axes, poses[-1:], line["color"], "", scale, marker="o", filled=True)
    grey: dict[str, Any] = {"color": "0.4", "linestyle": "none"}
    axes.plot([], [], marker="s", fillstyle="none", label="start", **grey)
    axes.plot([], [], marker="o", label="end", **grey)
    axes.margins(0.12)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(visible=True, alpha=0.3)


def save_picture(figure: Figure, path: Path) -> None:
    """Write a picture without a date, in the format of the suffix. Raises ToolError."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        text.set_text(printable(text.get_text(), "\n"))
    kind = path.suffix.lower()[1:]
    undated: dict[str, Any] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    try:
        figure.savefig(path, format=kind, metadata=undated.get(kind))
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror}") from error
    except ValueError as error:
        # SOURCE_DATE_EPOCH, for instance, is read by matplotlib.
        raise ToolError(f"matplotlib cannot write {path}: {error}") from error


def _extent(poses: Sequence[Pose]) -> float:
    spans = [max(values) - min(values) for values in list(zip(*poses, strict=True))[:2]]
    return max(spans, default=0.0)


def _mark(
    axes: Axes,
    poses: Sequence[Pose],
    colour: str,
    label: str,
    scale: float,
    *,
    marker: str,
    size: float = 6,
    filled: bool = False,
) -> None:
    if not poses:
        return
    xs, ys = [p[0] for p in poses], [p[1] for p in poses]
    axes.plot(
        xs,
        ys,
        marker,
        color=colour,
        markersize=size,
        fillstyle="full" if filled else "none",
        markeredgewidth=1.8,
        label=label or None,
    )
    axes.quiver(
        xs,
        ys,
        [scale * math.cos(p[2]) for p in poses],
        [scale * math.sin(p[2]) for p in poses],
        angles="xy",
        scale_units="xy",
        scale=1.0,
        color=colour,
        width=0.005,
    )
