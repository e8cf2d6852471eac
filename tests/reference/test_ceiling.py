"""Lamps on the ceiling: pictures of the camera, and the pose computed from them."""

from __future__ import annotations

from math import hypot, pi
from pathlib import Path

import pytest
from component_bench import Bench
from hypothesis import given
from hypothesis import strategies as st
from pipeline import NAVIGATION

from refnav.ceiling import (
    Lamp,
    View,
    blobs,
    fitted,
    in_body,
    parse,
    picture,
    recognised,
)
from refnav.ceiling_camera import CeilingCamera
from refnav.ceiling_navigation import CeilingNavigation
from refnav.geometry import Pose, wrap
from refnav.map_text import MapError
from refrobots import iis, rtc
from rtgen.runtime import LifeCycleState

VIEW = View(320, 240, 160, 120, 0.01)
LAMPS = parse((NAVIGATION / "ceiling_map").read_text(encoding="utf-8"), "ceiling_map")


def sample(pose: Pose, sec: int = 0) -> iis.TimedPose2D:
    data = rtc.Pose2D(rtc.Point2D(pose.x, pose.y), pose.theta)
    return iis.TimedPose2D(rtc.Time(sec, 0), [], data, [])


INSIDE = st.builds(Pose, st.floats(0.0, 4.0), st.floats(0.0, 8.0), st.floats(-pi, pi))


@given(INSIDE, st.floats(-0.08, 0.08), st.floats(-0.08, 0.08), st.floats(-0.05, 0.05))
def test_a_picture_tells_the_pose(pose: Pose, x: float, y: float, turn: float) -> None:
    image = picture(LAMPS, pose, VIEW)
    seen = [in_body(blob, VIEW) for blob in blobs(image, VIEW, 220)]
    about = Pose(pose.x + x, pose.y + y, pose.theta + turn)
    found = fitted(recognised(seen, LAMPS, about, 2.0))
    assert found is not None
    assert hypot(found.x - pose.x, found.y - pose.y) < 0.01
    assert abs(wrap(found.theta - pose.theta)) < 0.01


@pytest.mark.parametrize(
    ("scope", "off", "found"), [(2.0, 0.39, 1), (2.0, 0.41, 0), (1.0, 0.21, 0)]
)
def test_a_lamp_is_looked_for_within_its_scope(
    scope: float, off: float, found: int
) -> None:
    lamps = [Lamp(1.0, 0.0, 0.1), Lamp(9.0, 0.0, 2.0)]
    for spot in ((1.0 + off, 0.0), (1.0, off), (1.0, -off)):
        assert len(recognised([spot], lamps, Pose(0.0, 0.0, 0.0), scope)) == found


def test_spots_cut_by_the_edge_are_left_out() -> None:
    view = View(8, 6, 4, 3, 1.0)
    image = bytearray(48)
    image[0] = 255
    image[18:20] = b"\xff\xff"
    [blob] = blobs(image, view, 220)
    assert blob[:3] == (2.5, 2.0, 2)
    assert blob.coefficient == 1.0


def test_a_spot_may_grow_together_from_two() -> None:
    view = View(9, 6, 4, 3, 1.0)
    rows = [
        "         ",
        " # #  #  ",
        " # #  #  ",
        " ###  #  ",
        "         ",
        "         ",
    ]
    image = "".join(rows).encode().translate(bytes.maketrans(b" #", b"\x00\xff"))
    found = sorted(blobs(image, view, 1))
    assert [(blob.pixels, blob.column) for blob in found] == [(7, 2.0), (3, 6.0)]
    assert found[0].coefficient == pytest.approx(7 / 9)


def test_one_lamp_alone_tells_no_pose() -> None:
    assert fitted([((0.0, 0.0), LAMPS[0])]) is None


def ceiling() -> Bench:
    bench = Bench(CeilingNavigation("CeilingNavigation0"), 50.0)
    bench.component.folder = NAVIGATION
    bench.activate()
    return bench


def test_the_pose_has_the_time_of_the_picture_in_spite_of_wrong_pixels() -> None:
    camera = Bench(CeilingCamera("CeilingCamera0"), 10.0)
    camera.component.folder = NAVIGATION
    camera.activate()
    pose = Pose(2.0, 4.0, 1.0)
    camera.send("pose", sample(pose, sec=9))
    camera.run(0.1)
    [taken] = camera.sent("CameraData")
    assert taken.tm == rtc.Time(9, 0)
    assert taken.data != bytes(picture(LAMPS, pose, VIEW))
    bench = ceiling()
    bench.send("LocalizedPosition", sample(Pose(2.1, 3.9, 1.03), sec=9))
    bench.send("LocalizedPosition", sample(Pose(3.0, 3.0, 2.0), sec=10))
    bench.send("CameraData", taken)
    bench.run(0.02)
    [found] = bench.sent("CeilingPosition")
    assert found.tm == taken.tm
    assert found.data.position.x == pytest.approx(2.0, abs=0.005)
    assert found.data.position.y == pytest.approx(4.0, abs=0.005)
    assert found.data.heading == pytest.approx(1.0, abs=0.005)


def test_a_dark_ceiling_tells_nothing() -> None:
    bench = ceiling()
    bench.send("LocalizedPosition", sample(Pose(2.0, 4.0, 1.0)))
    bench.send("CameraData", rtc.TimedOctetSeq(data=bytes(320 * 240)))
    bench.run(0.02)
    assert bench.sent("CeilingPosition") == []
    assert bench.state is LifeCycleState.ACTIVE_STATE


def test_a_picture_of_another_size_is_an_error() -> None:
    bench = ceiling()
    bench.send("LocalizedPosition", sample(Pose(2.0, 4.0, 1.0)))
    bench.send("CameraData", rtc.TimedOctetSeq(data=bytes(1000)))
    bench.run(0.04)
    assert bench.component.reason == "CameraData: 1000 pixels are not rows of 320"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "ceiling_map:1: no lamp"),
        ("m 0 0\n", "ceiling_map:1: m and 3 finite numbers expected"),
        ("m 0 0 0\n", "ceiling_map:1: a lamp has a radius above 0"),
    ],
)
def test_what_is_no_ceiling(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(MapError) as caught:
        parse(text, "ceiling_map")
    assert str(caught.value) == why
    (tmp_path / "ceiling_map").write_text(text, encoding="utf-8")
    for component, parameter in (
        (CeilingCamera("C0"), "ceiling_map"),
        (CeilingNavigation("C1"), "NavigationMap"),
    ):
        component.folder = tmp_path
        bench = Bench(component, 10.0)
        bench.activate()
        assert component.reason == f"{parameter}: {why}"
