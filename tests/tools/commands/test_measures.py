"""Measures of the poses in a run."""

from __future__ import annotations

from math import cos, inf, pi, sin
from typing import Any

import pytest

from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.systems.measures import (
    Course,
    Measure,
    Pose,
    Result,
    evaluate,
    parse,
)

TIMES = [0.0, 1.0, 2.0, 3.0]


def place(key: str) -> Span:
    return Span(key or "table", 1, 1, 1, 2)


def measure(kind: str, **keys: Any) -> Measure:
    begin = {"from": keys.pop("begin")} if "begin" in keys else {}
    return parse({"name": "m", "kind": kind, "of": "A", **keys, **begin}, place)


def course(one: list[Pose], other: list[Pose] | None = None) -> Course:
    return Course(TIMES[: len(one)], {"A": one, "B": other or one})


def seen(m: Measure, c: Course) -> tuple[float, float]:
    found = evaluate(m, c).seen
    assert found is not None
    return found


LINE: list[Pose] = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 0.0)]
ASIDE: list[Pose] = [(0.0, 1.0, 0), (1.0, 1.0, 0), (2.0, 2.0, 0), (3.0, -1.0, 0)]


def test_distance_between_two() -> None:
    both = course(LINE, ASIDE)
    assert seen(measure("distance", to="B"), both) == (1.0, 2.0)
    assert seen(measure("distance", to="B", begin=1, until=1.5), both) == (1.0, 1.0)


def test_distance_from_a_track() -> None:
    assert seen(measure("track", to="B"), course(LINE, ASIDE)) == pytest.approx(
        (0.1**0.5, 2.0**0.5)
    )
    # Only distances from previous positions count, and only since then.
    ahead = course([(0, 0, 0)] * 4, LINE)
    assert seen(measure("track", to="B", begin=3, since=2), ahead) == (2.0, 2.0)
    behind: list[Pose] = [(3, 0, 0), (3, 0, 0), (2, 0, 0), (1, 0, 0)]
    assert seen(measure("track", to="B"), course(behind, LINE)) == (0.0, 3.0)


def test_inside_an_area() -> None:
    assert seen(measure("inside", area=[0, 0, 2, 1]), course(LINE)) == (0.0, 1.0)
    assert seen(measure("inside", area=[-1, 3, 9, 9]), course(LINE)) == (3.0, 3.0)
    assert evaluate(measure("inside", area=[0, 0, 3, 0]), course(LINE)).kept
    assert not evaluate(measure("inside", area=[0, 0, 2, 0]), course(LINE)).kept


def test_moved() -> None:
    assert seen(measure("moved"), course(LINE)) == (0.0, 3.0)
    assert seen(measure("moved", begin=1, until=2), course(LINE)) == (0.0, 1.0)


def test_alike_wherever_they_began() -> None:
    turned: list[Pose] = [(5 + i * cos(2.0), 7 + i * sin(2.0), 2.0) for i in range(4)]
    low, high = seen(measure("alike", to="B"), course(LINE, turned))
    assert (low, high) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert seen(measure("alike", to="B"), course(LINE, ASIDE))[1] == 2.0


def test_displacement_as_seen_from_its_beginning() -> None:
    left: list[Pose] = [(1, 1, pi / 2), (1, 2, pi / 2), (0, 3, pi)]
    wanted = measure("displacement", expected=[2, 1, pi / 2])
    assert seen(wanted, course(left))[1] == pytest.approx(0.0, abs=1e-12)
    near = measure("displacement", expected=[2, 1.1, pi / 2])
    assert seen(near, course(left))[1] == pytest.approx(0.1)
    twisted = measure("displacement", expected=[2, 1.1, pi])
    assert seen(twisted, course(left))[1] == pytest.approx(pi / 2)


@pytest.mark.parametrize(
    ("limits", "fine"),
    [
        ({}, True),
        ({"most": 2.9}, False),
        ({"most": 3}, True),
        ({"least": 0.1}, False),
        ({"least": 0.1, "begin": 5}, False),
    ],
)
def test_limits(limits: dict[str, float], fine: bool) -> None:
    assert evaluate(measure("moved", **limits), course(LINE)).kept is fine


def test_nothing_to_measure_is_not_kept() -> None:
    found = evaluate(measure("moved", begin=50, until=60), course(LINE))
    assert found.seen is None
    assert not found.kept


def test_a_robot_that_is_nowhere_keeps_no_limit() -> None:
    nan = float("nan")
    lost: list[Pose] = [(nan, nan, nan)] * 2
    assert not evaluate(measure("moved", most=1), course(lost)).kept
    assert not Result(measure("moved", most=1), (0.0, inf)).kept


@pytest.mark.parametrize(
    ("table", "key", "message"),
    [
        ({"kind": "moved", "of": "A"}, "", "needs name"),
        ({"name": "", "kind": "moved", "of": "A"}, "", "needs name"),
        ({"name": "m", "kind": "moved", "of": 3}, "", "needs of"),
        ({"name": "m", "kind": "mved", "of": "A"}, "kind", "no kind 'mved'"),
        ({"name": "m", "kind": "moved", "of": "A", "to": "B"}, "to", "unknown key"),
        ({"name": "m", "kind": "alike", "of": "A"}, "to", "needs to"),
        ({"name": "m", "kind": "moved", "of": "A", "most": True}, "", "numbers"),
        ({"name": "m", "kind": "moved", "of": "A", "most": 10**400}, "", "numbers"),
        ({"name": "m", "kind": "moved", "of": "A", "from": "1"}, "", "numbers"),
        ({"name": "m", "kind": "inside", "of": "A"}, "area", "4 numbers"),
        (
            {"name": "m", "kind": "inside", "of": "A", "area": [0, 0, 1, inf]},
            "area",
            "4 numbers",
        ),
    ],
)
def test_what_is_no_measure_is_reported_at_its_place(
    table: dict[str, Any], key: str, message: str
) -> None:
    with pytest.raises(InputError) as error:
        parse(table, place)
    [finding] = error.value.diagnostics
    assert finding.code == "SYS0010"
    assert message in finding.message
    assert finding.span == place(key)
