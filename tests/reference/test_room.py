"""Rays in a room, and the free distance of a body along an arc."""

from __future__ import annotations

from math import cos, hypot, inf, pi, sin

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from refnav.free_way import free_way
from refnav.geometry import Pose, advance
from refnav.map_text import MapError
from refnav.room import Post, Room, Wall, parse

PLACE = st.floats(-3.0, 3.0).map(lambda place: round(place, 6))
ANGLE = st.floats(-pi, pi).map(lambda angle: round(angle, 6))
THING = st.one_of(
    st.builds(Wall, PLACE, PLACE, PLACE, PLACE).filter(
        lambda wall: hypot(wall.x1 - wall.x2, wall.y1 - wall.y2) > 0.1
    ),
    st.builds(Post, PLACE, PLACE, st.floats(0.1, 1.0)),
)
ROOM = st.lists(THING, min_size=1, max_size=4).map(Room)


@given(ROOM, PLACE, PLACE, ANGLE)
@example(Room([Wall(0.0, 0.0, 1.0, 0.0)]), -1.0, 0.0, 0.0)
@example(Room([Wall(1.0, 0.0, -2.0, 0.0)]), -3.0, 0.0, 0.0)
def test_a_ray_ends_at_the_first_thing(
    room: Room, x: float, y: float, angle: float
) -> None:
    [reach] = room.ranges(Pose(x, y, 0.0), [angle], 4.0)
    if room.distance(x, y) < 1e-3:
        return
    if reach != inf:
        end = room.distance(x + reach * cos(angle), y + reach * sin(angle))
        assert end == pytest.approx(0.0, abs=1e-6)
    # Before its end the ray has touched nothing.
    step = min(reach, 4.0) / 50
    for i in range(1, 49):
        way = i * step
        assert room.distance(x + way * cos(angle), y + way * sin(angle)) > 0.0


def test_nothing_is_seen_beyond_the_range() -> None:
    room = Room([Wall(5.0, -1.0, 5.0, 1.0)])
    assert room.ranges(Pose(0.0, 0.0, 0.0), [0.0], 4.0) == [inf]
    assert room.ranges(Pose(1.5, 0.0, pi), [pi, 0.0], 4.0) == [3.5, inf]
    assert Room([]).distance(0.0, 0.0) == inf


@given(
    st.lists(st.tuples(PLACE, PLACE), max_size=5),
    st.floats(-2.0, 2.0),
    st.floats(0.1, 0.6),
)
def test_a_body_on_a_free_way_touches_nothing(
    points: list[tuple[float, float]], curvature: float, radius: float
) -> None:
    outside = [(x, y) for x, y in points if hypot(x, y) > radius]
    free = free_way(curvature, outside, radius, 3.0)
    assert 0.0 <= free <= 3.0
    for i in range(61):
        way = free * i / 60
        x, y, _ = advance(0.0, 0.0, 0.0, way, way * curvature)
        assert all(hypot(px - x, py - y) > radius - 1e-6 for px, py in outside)
    if free < 3.0:
        x, y, _ = advance(0.0, 0.0, 0.0, free, free * curvature)
        nearest = min(hypot(px - x, py - y) for px, py in outside)
        assert nearest == pytest.approx(radius, abs=1e-5)


@pytest.mark.parametrize(
    ("point", "free"), [((0.1, 0.1), 0.0), ((-0.1, 0.1), 2.0), ((0.0, 0.49), 2.0)]
)
@pytest.mark.parametrize("curvature", [0.0, 0.5, -0.5])
def test_what_touches_already_stops_only_a_body_that_drives_towards_it(
    point: tuple[float, float], free: float, curvature: float
) -> None:
    assert free_way(curvature, [point], 0.5, 2.0) == free


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("w 0 0 0\n", "room:1: w and 4 finite numbers expected"),
        ("w 1 1 1 1\n", "room:1: a wall has a length"),
        ("\nc 0 0 -1\n", "room:2: a post has a radius above 0"),
    ],
)
def test_what_is_no_room(text: str, why: str) -> None:
    with pytest.raises(MapError) as caught:
        parse(text, "room")
    assert str(caught.value) == why


def test_an_empty_text_is_an_empty_room() -> None:
    assert parse("# nothing\n", "room").things == []
