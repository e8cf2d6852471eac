"""The end of a run on standard output: a table of components, then what came out."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass

from rtgen.cli.recording import Pose
from rtgen.measures import Result

_MEASURES = ("measure", "from", "until", "least", "greatest", "allowed", "kept")
_NEVER = 1e9
_HEADER = ("instance", "state", "ticks", "overruns", "lost")


@dataclass(frozen=True, slots=True)
class Row:
    """A component at the end of a run; `reason` says why it is in ERROR, or what it waits for."""

    instance: str
    state: str
    ticks: int
    overruns: int
    lost: int
    reason: str


@dataclass(frozen=True, slots=True)
class Outcome:
    """A run: its components, its end in the plane if it has one, times in seconds.

    `poses` are those of the robots at the end, by name; the goal is that of a single one.
    """

    rows: Sequence[Row]
    goal: Pose | None
    poses: Sequence[tuple[str, Pose]]
    simulated: float
    wall: float
    measured: Sequence[Result] = ()


def summary(outcome: Outcome) -> str:
    """The table, the lines, and the reasons of components in ERROR or waiting."""
    cells = [
        (r.instance, r.state, str(r.ticks), str(r.overruns), str(r.lost))
        for r in outcome.rows
    ]
    lines = [*_table(_HEADER, cells, texts=(0, 1)), ""]
    results = [*_results(outcome)]
    width = max(len(name) for name, _ in results)
    lines += [f"{name:<{width}}  {value}" for name, value in results]
    if outcome.measured:
        lines += ["", *_table(_MEASURES, map(_measured, outcome.measured), (0, 5, 6))]
    reasons = [f"{row.instance}: {row.reason}" for row in outcome.rows if row.reason]
    if reasons:
        lines += ["", *reasons]
    return "".join(f"{line}\n" for line in lines)


def _table(
    header: tuple[str, ...], rows: Iterable[tuple[str, ...]], texts: Container[int]
) -> list[str]:
    """Lines with columns; those of `texts` to the left, those of numbers to the right."""
    cells = [header, *rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(
            text.ljust(width) if column in texts else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]


def _measured(result: Result) -> tuple[str, ...]:
    measure = result.measure
    low, high = result.seen or (math.nan, math.nan)
    most = "" if measure.most >= _NEVER else f"{measure.most:g}"
    least = f"{measure.least:g}" if measure.least > 0.0 or not most else "0"
    return (
        measure.name,
        f"{measure.begin:g}",
        "end" if measure.end >= _NEVER else f"{measure.end:g}",
        f"{low:.3f}",
        f"{high:.3f}",
        f"{least} .. {most}".rstrip(),
        "yes" if result.kept else "NO",
    )


def _results(outcome: Outcome) -> list[tuple[str, str]]:
    goal = outcome.goal
    results = []
    if goal is not None:
        results.append(("goal", _pose(goal)))
    alone = len(outcome.poses) == 1
    for name, pose in outcome.poses:
        results.append(("final pose" if alone else f"final pose {name}", _pose(pose)))
    if goal is not None and alone:
        [(_, pose)] = outcome.poses
        distance = math.hypot(goal[0] - pose[0], goal[1] - pose[1])
        turn = abs(math.remainder(goal[2] - pose[2], math.tau))
        results.append(("position error [m]", f"{distance:.6f}"))
        results.append(("heading error [rad]", f"{turn:.6f}"))
    results.append(("simulated [s]", f"{outcome.simulated:.3f}"))
    results.append(("wall [s]", f"{outcome.wall:.3f}"))
    ratio = outcome.simulated / outcome.wall if outcome.wall > 0.0 else math.inf
    results.append(("ratio", f"{ratio:.1f}"))
    return results


def _pose(pose: Pose) -> str:
    return "({:.4f}, {:.4f}, {:.4f})".format(*pose)
