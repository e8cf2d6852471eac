"""Figures 122 and 123 on the embedded runtime: range sensor, ucodes, and the whole system."""

from __future__ import annotations

from math import hypot, pi
from pathlib import Path

import pytest
from component_bench import Bench
from pipeline import build, profile

from refnav.contents_interpretation import ContentsInterpretation
from refnav.hokuyo_aist import HokuyoAist
from refnav.recent import Recent, octets_of
from refnav.ucode_reader import UcodeReader
from refnav.ucode_settlement import UcodeSettlement
from refnav.urg_to_obstacles import points_of
from refrobots import iis, rtc, ucode
from rtgen.runtime import SECOND, LifeCycleState, Record, SampleRecord

ENVIRONMENT = Path(__file__).parents[2] / "specs" / "embedded" / "environment.xml"


def pose(x: float, y: float, theta: float) -> iis.TimedPose2D:
    data = rtc.Pose2D(rtc.Point2D(x, y), theta)
    return iis.TimedPose2D(rtc.Time(3, 4), [], data, [])


def sightings(*digits: str) -> ucode.TimedSightings:
    seen = [ucode.Sighting(octets_of(text), 0.5 * i) for i, text in enumerate(digits)]
    return ucode.TimedSightings(data=seen)


def record(digits: str, text: str) -> ucode.TimedRecord:
    return ucode.TimedRecord(code=octets_of(digits), known=text != "", record=text)


def test_a_scan_measures_the_walls() -> None:
    bench = Bench(HokuyoAist("HokuyoAist0"), 10.0)
    bench.set(walls="2 -9 2 9; -1 -9 -1 9", rays="5", max_range="3.0")
    bench.set(start_angle=str(-pi / 2), end_angle=str(pi / 2))
    bench.activate()
    bench.send("pose", pose(0.0, 0.0, 0.0))
    bench.run(0.1)
    [scan] = bench.sent("range")
    assert scan.tm == rtc.Time(3, 4)
    assert scan.ranges == [0.0, pytest.approx(8**0.5), 2.0, pytest.approx(8**0.5), 0.0]
    assert scan.config.angularRes == pytest.approx(pi / 4)


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"walls": "1 2 3"}, "walls: 1 2 3 is not a wall"),
        ({"end_angle": "-3.0"}, "end_angle is not above start_angle"),
    ],
)
def test_a_range_finder_that_cannot_work(parameters: dict[str, str], why: str) -> None:
    bench = Bench(HokuyoAist("HokuyoAist0"), 10.0)
    bench.set(**parameters)
    bench.activate()
    assert (bench.state, bench.component.reason) == (LifeCycleState.ERROR_STATE, why)


def test_markers_in_view_are_read_the_nearest_first() -> None:
    bench = Bench(UcodeReader("UcodeReader0"), 5.0)
    bench.set(markers="a 2 0; b 1 0; c -1 0; d 1 1.9; e 3.1 0", reach="2.5", angle="1")
    bench.activate()
    bench.send("pose", pose(0.0, 0.0, 0.0))
    bench.run(0.2)
    [reading] = bench.sent("sightings")
    assert [s.code for s in reading.data] == [octets_of("b"), octets_of("a")]
    assert [s.distance for s in reading.data] == [1.0, 2.0]
    bench.send("pose", pose(0.0, 0.0, pi))
    bench.run(0.2)
    [reading] = bench.sent("sightings")
    assert [s.code for s in reading.data] == [octets_of("c")]
    assert reading.data[0].bearing == pytest.approx(0.0, abs=1e-12)
    bench.send("pose", pose(9.0, 9.0, 0.0))
    bench.run(0.2)
    assert bench.sent("sightings") == []


def test_walls_hide_markers() -> None:
    bench = Bench(UcodeReader("UcodeReader0"), 5.0)
    bench.set(
        markers="a 2 0; b 1 0.1; c 1.5 -0.5", walls="1.5 -0.2 1.5 0.2; 1.5 -1 1.5 -0.3"
    )
    bench.activate()
    bench.send("pose", pose(0.0, 0.0, 0.0))
    bench.run(0.2)
    [reading] = bench.sent("sightings")
    # A marker behind a wall is hidden, one on a wall is visible.
    assert [s.code for s in reading.data] == [octets_of("b"), octets_of("c")]


def test_walls_that_are_none() -> None:
    bench = Bench(UcodeReader("UcodeReader0"), 5.0)
    bench.set(walls="1 2 3")
    bench.activate()
    assert bench.component.reason == "walls: 1 2 3 is not a wall"


def test_what_was_not_hit_is_no_obstacle_at_the_sensor() -> None:
    bench = Bench(HokuyoAist("HokuyoAist0"), 10.0)
    bench.set(walls="0.01 -9 0.01 9; -1 -9 -1 9", rays="3", max_range="3.0")
    bench.set(start_angle="-3.1", end_angle="3.1")
    bench.activate()
    bench.send("pose", pose(0.0, 0.0, 0.0))
    bench.run(0.1)
    [scan] = bench.sent("range")
    # Ranges below the least range are not measured either.
    assert (scan.config.minRange, scan.ranges[1]) == (0.02, 0.0)
    assert [hypot(p.x, p.y) for p in points_of(scan, 0.0)] == [
        pytest.approx(1.0, abs=0.01)
    ] * 2
    # Also of a range finder without a least range.
    scan.config.minRange = 0.0
    assert len(points_of(scan, 0.0)) == 2


@pytest.mark.parametrize("text", ["1 2", "xyz 1 2", "1 a 2"])
def test_markers_that_are_none(text: str) -> None:
    bench = Bench(UcodeReader("UcodeReader0"), 5.0)
    bench.set(markers=text)
    bench.activate()
    assert bench.state is LifeCycleState.ERROR_STATE


def test_a_record_that_is_at_hand_comes_at_once() -> None:
    bench = Bench(UcodeSettlement("UcodeSettlement0"), 20.0)
    bench.set(records="1 1 0 room a; 2 2 0 room b; 3 3 0 room c", cache="2", delay="3")
    bench.activate()
    asked = bench.component.observables["asked"]

    def settled(*digits: str) -> tuple[str, bool, int]:
        bench.send("sightings", sightings(*digits))
        for executions in range(1, 9):
            bench.run(0.05)
            if found := bench.sent("record"):
                return found[0].record, found[0].cached, executions
        raise AssertionError("no record")

    assert settled("1", "2") == ("1 0 room a", False, 4)
    assert settled("1") == ("1 0 room a", True, 1)
    assert settled("2") == ("2 0 room b", False, 4)
    assert settled("1") == ("1 0 room a", True, 1)
    # The third replaces the second, the least recently used one.
    assert settled("3") == ("3 0 room c", False, 4)
    assert settled("1") == ("1 0 room a", True, 1)
    assert settled("2") == ("2 0 room b", False, 4)
    assert asked() == (4.0,)
    assert settled("9") == ("", False, 4)


def test_contents_are_interpreted_once() -> None:
    bench = Bench(ContentsInterpretation("ContentsInterpretation0"), 20.0)
    bench.activate()
    for text in ("1.5 -2 door to the north", "", "1.5 -2 door to the north"):
        bench.send("record", record("7", text))
    bench.run(0.05)
    found = bench.sent("contents")
    assert [(c.position.x, c.position.y, c.kind, c.name) for c in found] == [
        (1.5, -2.0, "door", "to the north")
    ] * 2
    assert bench.component.observables["interpreted"]() == (1.0,)


@pytest.mark.parametrize("text", ["1 2 door", "a 2 door x"])
def test_a_record_that_nobody_understands(text: str) -> None:
    bench = Bench(ContentsInterpretation("ContentsInterpretation0"), 20.0)
    bench.activate()
    bench.send("record", record("7", text))
    bench.run(0.05)
    assert bench.component.reason == f"record: {text} is not X Y KIND NAME"


def test_places_are_taken_from_the_one_not_needed_for_longest() -> None:
    recent = Recent(2)
    first, second = recent.take(b"a"), recent.take(b"b")
    assert {first, second} == {0, 1}
    assert recent.find(b"a") == first
    assert recent.take(b"c") == second
    assert recent.find(b"b") == -1


@pytest.mark.sampled(0)
def test_a_base_learns_where_it_passes() -> None:
    places: list[str] = []

    def note(entry: Record) -> None:
        if isinstance(entry, SampleRecord) and entry.port == "contents":
            name = entry.value.name
            if not places or places[-1] != name:
                places.append(name)

    with build(profile(ENVIRONMENT)) as system:
        system.add_listener(note)
        system.run(20 * SECOND)
        assert system.observable("UcodeSettlement0.asked") == (4.0,)
    assert places == ["kitchen", "north", "workshop", "east"]
