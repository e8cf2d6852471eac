"""The report at the end of a run on standard output: a table of components, then the results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import msgspec

from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.compiler.systems.measures import Result
from rtgen.facts.columns import table
from rtgen.runtime.system.latency import Latency
from rtgen.tools.running.trajectory import Pose

_MEASURES = ("measure", "from", "until", "least", "greatest", "allowed", "kept")
_NEVER = 1e9
_LATENCIES = ("samples", "median [ms]", "99 % [ms]", "greatest [ms]", "chain")
_MAX_CHAINS = 8
"""Number of chains in the report; --json has all that are measured."""
_HEADER = ("instance", "state", "ticks", "overruns", "lost")


class Tolerance(NamedTuple):
    """Largest distance from the goal at the end of a run [m, rad]."""

    distance: float
    turn: float = math.inf


@dataclass(frozen=True, slots=True)
class Row:
    """A component at the end of a run.

    `notes` give the cause of ERROR, the awaited provider, and lost samples with their causes. Ticks
    and overruns of a component of another process are not known (None).
    """

    instance: str
    state: str
    ticks: int | None
    overruns: int | None
    lost: int
    notes: Sequence[str] = ()
    failed: bool = False
    """Whether it is in ERROR, which is not the end of its work."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of a run.

    `time` is the time since the start [s], `wall` the wall time of a run in simulated time [s]
    (None in real time). `poses` are the final poses of the robots by name; `goal` is that of a
    single robot, which must be within `tolerance` if given.
    """

    rows: Sequence[Row]
    goal: Pose | None
    poses: Sequence[tuple[str, Pose]]
    time: float
    wall: float | None
    measured: Sequence[Result] = ()
    tolerance: Tolerance | None = None
    links: Sequence[str] = ()
    """What has happened to connections to other processes."""
    end: tuple[str, str] | None = None
    """`met` or `not met`, and the condition, for a run that waited for a state."""
    latencies: Sequence[Latency] = ()
    """Of the samples along chains of connections, the longest chains first."""

    @property
    def errors(self) -> tuple[float, float] | None:
        """Distance [m] and angle [rad] from goal to pose; None if either is unknown."""
        if self.goal is None or len(self.poses) != 1:
            return None
        [(_, pose)] = self.poses
        goal = self.goal
        distance = math.hypot(goal[0] - pose[0], goal[1] - pose[1])
        return distance, abs(math.remainder(goal[2] - pose[2], math.tau))

    @property
    def missed(self) -> str:
        """Why the final pose violates the tolerance; empty if it does not."""
        if self.tolerance is None:
            return ""
        if self.errors is None:
            return "no goal, or no pose, to judge the end by"
        distance, turn = self.errors
        if not distance <= self.tolerance.distance:
            return (
                f"{distance:.3f} m from the goal, allowed {self.tolerance.distance:g} m"
            )
        if not turn <= self.tolerance.turn:
            return f"{turn:.3f} rad off the goal's heading, allowed {self.tolerance.turn:g} rad"
        return ""


def summary(outcome: Outcome) -> str:
    """Return the report as text in the language."""
    cells = [
        (
            r.instance,
            translated_word(r.state),
            *map(_count, (r.ticks, r.overruns, r.lost)),
        )
        for r in outcome.rows
    ]
    lines = [
        *table([tuple(map(translated_word, _HEADER)), *cells], right=(2, 3, 4)),
        "",
    ]
    results = [(translated_word(name), value) for name, value in _results(outcome)]
    lines += table(results)
    if outcome.measured:
        rows = [
            tuple(map(translated_word, _MEASURES)),
            *map(_measured, outcome.measured),
        ]
        lines += ["", *table(rows, right=(1, 2, 3, 4))]
    chains = [each for each in outcome.latencies if each.samples]
    if chains:
        shown = map(_latency, chains[:_MAX_CHAINS])
        lines += [
            "",
            *table(
                [tuple(map(translated_word, _LATENCIES)), *shown], right=(0, 1, 2, 3)
            ),
        ]
    if len(chains) > _MAX_CHAINS:
        more = f"chains that are not shown: {len(chains) - _MAX_CHAINS} (--json)"
        lines.append(translated(more))
    reasons = [note for row in outcome.rows for note in row.notes]
    reasons += outcome.links
    if outcome.missed:
        reasons.append(f"the goal is not reached: {outcome.missed}")
    if reasons:
        lines += ["", *map(translated, reasons)]
    return "".join(f"{line}\n" for line in lines)


def as_json(outcome: Outcome) -> str:
    """Return the report as JSON."""
    document = {
        "format": "rtgen-run/1",
        "components": [
            {
                "instance": row.instance,
                "state": row.state,
                "ticks": row.ticks,
                "overruns": row.overruns,
                "lost": row.lost,
                "notes": row.notes,
            }
            for row in outcome.rows
        ],
        "simulated" if outcome.wall is not None else "elapsed": outcome.time,
        "wall": outcome.wall,
        "end": outcome.end
        and {"met": outcome.end[0] == "met", "state": outcome.end[1]},
        "goal": outcome.goal,
        "poses": dict(outcome.poses),
        "measures": [
            {
                "name": each.measure.name,
                "seen": each.seen,
                "kept": each.kept,
            }
            for each in outcome.measured
        ],
        "links": outcome.links,
        "missed": outcome.missed,
        "latencies": outcome.latencies,
    }
    encoded = msgspec.json.encode(document)
    return msgspec.json.format(encoded, indent=2).decode() + "\n"


def _latency(chain: Latency) -> tuple[str, ...]:
    times = (chain.median, chain.late, chain.greatest)
    return str(chain.samples), *(f"{time / 1e6:.3f}" for time in times), chain.name


def _count(number: int | None) -> str:
    return "-" if number is None else str(number)


def _measured(result: Result) -> tuple[str, ...]:
    measure = result.measure
    low, high = result.seen or (math.nan, math.nan)
    most = "" if measure.most >= _NEVER else f"{measure.most:g}"
    least = f"{measure.least:g}" if measure.least > 0.0 or not most else "0"
    return (
        measure.name,
        f"{measure.begin:g}",
        translated_word("end") if measure.end >= _NEVER else f"{measure.end:g}",
        f"{low:.3f}",
        f"{high:.3f}",
        f"{least} .. {most}".rstrip(),
        translated_word("yes" if result.kept else "NO"),
    )


def _results(outcome: Outcome) -> list[tuple[str, str]]:
    goal = outcome.goal
    results = []
    if goal is not None:
        results.append(("goal", _pose(goal)))
    alone = len(outcome.poses) == 1
    for name, pose in outcome.poses:
        results.append(("final pose" if alone else f"final pose {name}", _pose(pose)))
    if outcome.errors is not None:
        distance, turn = outcome.errors
        results.append(("position error [m]", f"{distance:.6f}"))
        results.append(("heading error [rad]", f"{turn:.6f}"))
    if outcome.wall is None:
        results.append(("elapsed [s]", f"{outcome.time:.3f}"))
    else:
        ratio = outcome.time / outcome.wall if outcome.wall > 0.0 else math.inf
        results.append(("simulated [s]", f"{outcome.time:.3f}"))
        results.append(("wall [s]", f"{outcome.wall:.3f}"))
        results.append(("ratio", f"{ratio:.1f}"))
    if outcome.end is not None:
        results.append(outcome.end)
    return results


def _pose(pose: Pose) -> str:
    return "({:.4f}, {:.4f}, {:.4f})".format(*pose)
