"""Measures of poses during a run, and their limits: `[[measure]]`."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Final, TypeAlias

from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.systems.rules import MEASURE

Pose: TypeAlias = tuple[float, float, float]
"""x [m], y [m], heading [rad]."""

_MAX_VALUE = 1e9
_STEP = 0.05
"""Minimum distance of the points of a track [m]."""
_REQUIRED_KEYS: Final = ("name", "kind", "of")
_LIMITS: Final = ("from", "until", "least", "most")


@dataclass(frozen=True, slots=True)
class Measure:
    """A quantity [m] measured from `begin` to `end` [s], and its limits."""

    name: str
    kind: str
    of: str
    to: str | None
    begin: float
    end: float
    least: float
    most: float
    values: tuple[float, ...]
    span: Span = field(compare=False)

    @property
    def observables(self) -> tuple[str, ...]:
        """The observables that the measure needs."""
        return (self.of,) if self.to is None else (self.of, self.to)


@dataclass(frozen=True, slots=True)
class Result:
    """The minimum and the maximum; None if nothing was measured."""

    measure: Measure
    seen: tuple[float, float] | None

    @property
    def kept(self) -> bool:
        """Whether the limits were kept throughout."""
        if self.seen is None:
            return False
        return self.measure.least <= self.seen[0] and self.seen[1] <= self.measure.most


@dataclass(frozen=True, slots=True)
class Course:
    """The poses of a run: `times` [s], and for each observable its poses at these times."""

    times: Sequence[float]
    poses: Mapping[str, Sequence[Pose]]

    def between(self, begin: float, end: float) -> range:
        """Return the indices of the samples in a time span, both ends included."""
        first = bisect_left(self.times, begin - 1e-9)
        return range(first, bisect_right(self.times, end + 1e-9))


def parse(entry: Mapping[str, Any], place: Callable[[str], Span]) -> Measure:
    """Parse a table `[[measure]]`; `place` returns the places of its keys.

    Raises InputError.
    """

    def wrong(key: str, message: str, hint: str | None = None) -> InputError:
        return InputError([MEASURE.at(place(key), message, hint=hint)])

    for key in _REQUIRED_KEYS:
        if not isinstance(entry.get(key), str) or not entry[key]:
            raise wrong("", f"a measure needs {key}, a text")
    kind = _KINDS.get(entry["kind"])
    if kind is None:
        choices = ", ".join(_KINDS)
        raise wrong("kind", f"no kind {entry['kind']!r}", f"known: {choices}")
    needed = [*_REQUIRED_KEYS, *(["to"] if kind.two else []), *kind.keys]
    for key in entry:
        if key not in needed and key not in _LIMITS:
            choices = ", ".join([*needed, *_LIMITS])
            raise wrong(key, f"unknown key {key!r}; known: {choices}")
    to = entry.get("to")
    if kind.two and not (isinstance(to, str) and to):
        raise wrong("to", f"{entry['kind']!r} needs to, an observable")
    begin, end, least, most = (
        _number(entry.get(key, default))
        for key, default in zip(_LIMITS, (0.0, _MAX_VALUE, 0.0, kind.most), strict=True)
    )
    if begin is None or end is None or least is None or most is None:
        raise wrong("", f"{', '.join(_LIMITS)} must be numbers")
    values: list[float] = []
    for key, length in kind.keys.items():
        number = entry.get(key, 0.0 if length == 1 else None)
        numbers = [
            _number(n) for n in (number if isinstance(number, list) else [number])
        ]
        if len(numbers) != length or None in numbers:
            raise wrong(key, f"{key!r} must be {length} numbers")
        values += [n for n in numbers if n is not None]
    return Measure(
        entry["name"],
        entry["kind"],
        entry["of"],
        to,
        begin,
        end,
        least,
        most,
        tuple(values),
        place(""),
    )


def _number(value: Any) -> float | None:
    fine = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if fine and -_MAX_VALUE <= value <= _MAX_VALUE else None


def evaluate(measure: Measure, course: Course) -> Result:
    """Evaluate a measure."""
    values = [*_KINDS[measure.kind].values(measure, course)]
    return Result(measure, (min(values), max(values)) if values else None)


def _distance(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the distance between two robots."""
    one, other = _two(measure, course)
    for i in course.between(measure.begin, measure.end):
        yield _apart(one[i], other[i])


def _track(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the distance of a robot from the track of another, since `values[0]`."""
    follower, leader = _two(measure, course)
    [since] = measure.values
    track: list[Pose] = []
    grown = course.between(since, measure.end)
    looked: Pose | None = None
    for i in grown:
        if not track or _apart(track[-1], leader[i]) >= _STEP:
            track.append(leader[i])
        here = follower[i]
        if course.times[i] < measure.begin - 1e-9:
            continue
        if looked is None or _apart(looked, here) >= _STEP:
            looked = here
            yield _from_line(here, [*track, leader[i]])


def _inside(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the distance of a robot from an area: minimum x and y, maximum x and y."""
    left, bottom, right, top = measure.values
    poses = course.poses[measure.of]
    for i in course.between(measure.begin, measure.end):
        x, y, _ = poses[i]
        yield math.hypot(max(left - x, 0.0, x - right), max(bottom - y, 0.0, y - top))


def _moved(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the distance of a robot from its start."""
    poses = course.poses[measure.of]
    within = course.between(measure.begin, measure.end)
    for i in within:
        yield _apart(poses[i], poses[within[0]])


def _relative_distance(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the distance between two robots, both transformed to a common start pose."""
    one, other = _two(measure, course)
    within = course.between(measure.begin, measure.end)
    for i in within:
        yield _apart(
            _seen_from(one[within[0]], one[i]), _seen_from(other[within[0]], other[i])
        )


def _displacement(measure: Measure, course: Course) -> Iterator[float]:
    """Yield the deviation of the total motion from the expected one: the greater of m and rad."""
    poses = course.poses[measure.of]
    within = course.between(measure.begin, measure.end)
    if within:
        x, y, theta = _seen_from(poses[within[0]], poses[within[-1]])
        target = measure.values
        turn = abs(math.remainder(theta - target[2], math.tau))
        yield max(math.hypot(x - target[0], y - target[1]), turn)


@dataclass(frozen=True, slots=True)
class _Kind:
    values: Callable[[Measure, Course], Iterator[float]]
    two: bool = False
    keys: Mapping[str, int] = field(default_factory=dict)
    """Further keys with their numbers of values; a single value defaults to 0."""
    most: float = _MAX_VALUE


_KINDS = {
    "distance": _Kind(_distance, two=True),
    "track": _Kind(_track, two=True, keys={"since": 1}),
    "alike": _Kind(_relative_distance, two=True),
    "inside": _Kind(_inside, keys={"area": 4}, most=0.0),
    "moved": _Kind(_moved),
    "displacement": _Kind(_displacement, keys={"expected": 3}),
}


def _two(measure: Measure, course: Course) -> tuple[Sequence[Pose], Sequence[Pose]]:
    assert measure.to is not None
    return course.poses[measure.of], course.poses[measure.to]


def _apart(one: Pose, other: Pose) -> float:
    return math.hypot(other[0] - one[0], other[1] - one[1])


def _seen_from(start: Pose, pose: Pose) -> Pose:
    """Return a pose in the frame of another."""
    x, y = pose[0] - start[0], pose[1] - start[1]
    c, s = math.cos(start[2]), math.sin(start[2])
    return x * c + y * s, y * c - x * s, math.remainder(pose[2] - start[2], math.tau)


def _from_line(here: Pose, line: Sequence[Pose]) -> float:
    """Return the distance of a point from a polyline."""
    best = math.inf
    for (ax, ay, _), (bx, by, _) in pairwise(line):
        dx, dy = bx - ax, by - ay
        size = dx * dx + dy * dy
        along = 0.0
        if size > 0.0:
            along = ((here[0] - ax) * dx + (here[1] - ay) * dy) / size
            along = min(max(along, 0.0), 1.0)
        best = min(
            best, math.hypot(here[0] - ax - along * dx, here[1] - ay - along * dy)
        )
    return best
