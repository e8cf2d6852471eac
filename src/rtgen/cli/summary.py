"""The end of a run on standard output: a table of components, then what came out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rtgen.cli.recording import Pose

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
    """A run: its components, its end in the plane if it has one, times in seconds."""

    rows: Sequence[Row]
    goal: Pose | None
    pose: Pose | None
    simulated: float
    wall: float


def summary(outcome: Outcome) -> str:
    """The table, the lines, and the reasons of components in ERROR or waiting."""
    lines = [*_table(outcome.rows), ""]
    results = [*_results(outcome)]
    width = max(len(name) for name, _ in results)
    lines += [f"{name:<{width}}  {value}" for name, value in results]
    reasons = [f"{row.instance}: {row.reason}" for row in outcome.rows if row.reason]
    if reasons:
        lines += ["", *reasons]
    return "".join(f"{line}\n" for line in lines)


def _table(rows: Sequence[Row]) -> list[str]:
    cells = [_HEADER] + [
        (r.instance, r.state, str(r.ticks), str(r.overruns), str(r.lost)) for r in rows
    ]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(
            text.ljust(width) if column < 2 else text.rjust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]


def _results(outcome: Outcome) -> list[tuple[str, str]]:
    goal, pose = outcome.goal, outcome.pose
    results = []
    if goal is not None:
        results.append(("goal", _pose(goal)))
    if pose is not None:
        results.append(("final pose", _pose(pose)))
    if goal is not None and pose is not None:
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
