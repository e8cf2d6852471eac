"""Figure 2-4: a base drives round obstacles, stops before a wall, and obeys the game pad."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import hypot
from pathlib import Path

import pytest
from pipeline import NAVIGATION, at_end, build, placed, profile

from refnav.geometry import Pose
from refnav.room import Room, parse
from rtgen.runtime import SECOND, System

OBSTACLES = NAVIGATION / "obstacles.xml"
BODY = 0.45
"""Radius of the body [m], as in Odometry, ObstaclesAvoidance and CollisionDetection."""
WALLS = "w -2 -2 9 -2\nw -2 2 9 2\nw -2 -2 -2 2\nw 9 -2 9 2"
"""Those of the corridor in `room`."""


def room(name: str) -> Room:
    return parse((NAVIGATION / name).read_text(encoding="utf-8"), name)


def in_room(name: str) -> list[str]:
    """Return the settings for another room."""
    return [f"LRFCapture_URG0.room={name}", f"RefHw0.PlantRoom={name}"]


@dataclass
class Drive:
    """A run, with the true pose every 10 ms."""

    system: System
    poses: list[tuple[int, Pose]] = field(default_factory=list)

    def __post_init__(self) -> None:
        note = lambda: self.poses.append((self.system.time, self.pose))  # noqa: E731
        self.system.every(SECOND // 100, note)

    @property
    def pose(self) -> Pose:
        return Pose(*self.system.observable("RefHw0.truth"))

    def room_left(self, around: Room) -> float:
        """Return the least clearance between the body and any obstacle during the run [m]."""
        return min(around.distance(pose.x, pose.y) for _, pose in self.poses) - BODY

    def away(self, x: float, y: float) -> float:
        return hypot(self.pose.x - x, self.pose.y - y)


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[Drive, Path]:
    picture = tmp_path_factory.mktemp("obstacles") / "seen.svg"
    settings = [f"ObstacleMonitor0.picture={picture}"]
    settings += ["LRFCapture_URG0.resolution=0.03"]
    built = build(profile(OBSTACLES), settings)
    with built:
        run = Drive(built)
        assert built.run(100 * SECOND, at_end)
    return run, picture


def test_the_obstacle_is_passed_and_the_goal_reached(
    drive: tuple[Drive, Path],
) -> None:
    run, _ = drive
    _, last = run.poses[-1]
    assert run.room_left(room("room")) > 0.1
    assert hypot(last.x - 7.0, last.y) < 0.05
    # The first post stands on the straight line to the goal.
    assert max(abs(pose.y) for _, pose in run.poses) > 0.5


def test_the_monitor_draws_what_was_seen(drive: tuple[Drive, Path]) -> None:
    text = drive[1].read_text(encoding="utf-8")
    assert "<!-- obstacles -->" in text
    assert "<!-- trail -->" in text


@pytest.mark.sampled(0)
def test_a_blocked_corridor_stops_the_base_before_contact() -> None:
    settings = [*in_room("blocked_room"), "LRFCapture_URG0.resolution=0.02"]
    built = build(profile(OBSTACLES), settings)
    with built:
        run = Drive(built)
        built.run(SECOND // 10)
        built.deactivate("GamePad0")
        assert not built.run(45 * SECOND, at_end)
        # It searches a way, keeps away from the walls, and reports that there is none.
        assert run.room_left(room("blocked_room")) > 0.1
        assert max(pose.x for _, pose in run.poses) > 1.5
        condition = built.statistics("Navigation0").condition
        assert condition == "no nearer to (7, 0) for 20 s"


@pytest.mark.nightly
@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_a_base_that_no_attempt_has_led_past_stands_and_says_so(
    mirrored: float, tmp_path: Path
) -> None:
    file = tmp_path / "posts"
    posts = [(2.16, -1.203, 0.166), (2.156, 1.071, 0.254), (2.635, -0.524, 0.255)]
    lines = [f"c {x} {mirrored * y} {radius}" for x, y, radius in posts]
    file.write_text("\n".join([WALLS, *lines, ""]))
    settings = [
        *in_room(str(file)),
        *placed(Pose(0.0, -0.442 * mirrored, -0.795 * mirrored), "RefHw0"),
        "PositionInput0.01_x=5.364",
        f"PositionInput0.01_y={0.66 * mirrored}",
        "LRFCapture_URG0.noise=0.0163",
        "LRFCapture_URG0.seed=284",
        "LRFCapture_URG0.resolution=0.03",
    ]
    with build(profile(OBSTACLES), settings) as built:
        run = Drive(built)
        built.run(SECOND // 10)
        built.deactivate("GamePad0")
        assert not built.run(150 * SECOND, at_end)
        assert run.room_left(parse(file.read_text(), "posts")) > 0.1
        condition = built.statistics("ObstaclesAvoidance0").condition
        assert condition == "no way ahead, and none to turn to"
        stood = run.pose
        built.run(150 * SECOND)
        assert run.pose == stood


@pytest.mark.sampled(0)
def test_collision_detection_alone_stops_the_base_before_contact() -> None:
    built = build(profile(OBSTACLES), in_room("blocked_room"))
    with built:
        run = Drive(built)
        built.disconnect("PathFollower0.velocity_ObstaclesAvoidance0.velocity_in")
        built.disconnect("ObstaclesAvoidance0.velocity_out_SwitchInputRTC0.inVelAuto")
        built.connect(("PathFollower0", "velocity"), ("SwitchInputRTC0", "inVelAuto"))
        assert not built.run(40 * SECOND, at_end)
        assert built.observable("CollisionDetection0.stopped") == (1.0,)
        assert 0.05 < run.room_left(room("blocked_room")) < 0.3
        assert tuple(built.observable("RefHw0.wheels")) == (0.0, 0.0)


@pytest.mark.sampled(0)
def test_a_hand_takes_over_and_the_base_goes_on_by_itself() -> None:
    built = build(profile(OBSTACLES), ["GamePad0.script=hand.txt"])
    built.component("GamePad0").folder = Path(__file__).parent / "scripts"
    with built:
        run = Drive(built)
        built.run(SECOND // 10)
        built.deactivate("GamePad0")
        built.run(6 * SECOND)
        before = run.pose
        built.activate("GamePad0")
        built.run(9 * SECOND)
        held = run.pose
        # The stick is held still: the base stands although its goal is far.
        assert hypot(held.x - before.x, held.y - before.y) < 0.1
        assert built.run(120 * SECOND, at_end)
        assert run.away(7.0, 0.0) < 0.05
        assert run.room_left(room("room")) > 0.1


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "ahead",
    [0.9, *(pytest.param(each, marks=pytest.mark.nightly) for each in (1.0, 1.3))],
)
def test_a_post_close_ahead_is_turned_from_and_passed(
    ahead: float, tmp_path: Path
) -> None:
    post = tmp_path / "post"
    post.write_text(f"{WALLS}\nc {ahead + 0.2} 0.0 0.2\n")
    settings = [*in_room(str(post)), "LRFCapture_URG0.resolution=0.02"]
    with build(profile(OBSTACLES), [*settings, "PositionInput0.01_x=4.0"]) as built:
        run = Drive(built)
        built.run(SECOND // 10)
        built.deactivate("GamePad0")
        assert built.run(60 * SECOND, at_end)
        assert run.away(4.0, 0.0) < 0.05
        assert run.room_left(parse(post.read_text(), "post")) > 0.05


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize("mirrored", [1.0, -1.0])
@pytest.mark.parametrize(
    ("posts", "start", "goal"),
    [
        # The gap between the second post and the wall is narrower than it looks from afar.
        (
            [(2.134, -0.543, 0.149), (4.576, -0.543, 0.240)],
            Pose(0.0, 0.0, 0.0),
            (7.0, -0.0786),
        ),
        # The base arrives with its heading towards the closed side.
        ([(2.75, 0.739, 0.191)], Pose(0.0, 0.893, -0.973), (4.955, 0.61)),
    ],
)
def test_the_other_side_is_tried_before_the_base_gives_up(
    posts: list[tuple[float, float, float]],
    start: Pose,
    goal: tuple[float, float],
    mirrored: float,
    tmp_path: Path,
) -> None:
    file = tmp_path / "posts"
    lines = [f"c {x} {mirrored * y} {radius}" for x, y, radius in posts]
    file.write_text("\n".join([WALLS, *lines, ""]))
    x, y = goal[0], mirrored * goal[1]
    begin = Pose(start.x, mirrored * start.y, mirrored * start.theta)
    settings = [
        *in_room(str(file)),
        *placed(begin, "RefHw0"),
        f"PositionInput0.01_x={x}",
        f"PositionInput0.01_y={y}",
    ]
    with build(profile(OBSTACLES), settings) as built:
        run = Drive(built)
        built.run(SECOND // 10)
        built.deactivate("GamePad0")
        assert built.run(150 * SECOND, at_end)
        assert run.away(x, y) < 0.05
        assert run.room_left(parse(file.read_text(), "posts")) > 0.1


@pytest.mark.sampled(0)
def test_two_runs_are_the_same() -> None:
    ends = []
    for _ in range(2):
        with build(profile(OBSTACLES)) as built:
            built.run(6 * SECOND)
            ends.append(tuple(built.observable("RefHw0.truth")))
    assert ends[0] == ends[1]
    assert ends[0][0] > 0.5
