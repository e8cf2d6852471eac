"""The components of Figure 2-4, each alone."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from pathlib import Path
from types import ModuleType

import pytest
from component_bench import Bench
from pipeline import NAVIGATION

from refnav import disp_position, obstacle_monitor
from refnav.disp_position import DispPosition
from refnav.game_pad import GamePad
from refnav.geometry import advance
from refnav.lrf_capture_urg import LRFCapture_URG
from refnav.obstacle_monitor import ObstacleMonitor
from refnav.obstacles_avoidance import ObstaclesAvoidance
from refnav.pads import Sticks
from refnav.ref_hw import RefHw
from refnav.surroundings import Surroundings
from refnav.switch_input_rtc import SwitchInputRTC
from refnav.urg_to_obstacles import Urg_to_Obstacles
from refrobots import iis, rtc
from rtgen.runtime import SECOND, Component, LifeCycleState


def velocity(vx: float, va: float = 0.0) -> iis.TimedVelocity2D:
    return iis.TimedVelocity2D(data=rtc.Velocity2D(vx, 0.0, va))


def pose(x: float, y: float, theta: float) -> iis.TimedPose2D:
    return iis.TimedPose2D(data=rtc.Pose2D(rtc.Point2D(x, y), theta))


def points(*places: tuple[float, float]) -> iis.TimedPoint2DSeq:
    return iis.TimedPoint2DSeq(data=[rtc.Point2D(x, y) for x, y in places])


def components_of(samples: list[iis.TimedVelocity2D]) -> list[tuple[float, float]]:
    return [(sample.data.vx, sample.data.va) for sample in samples]


def switch() -> Bench:
    bench = Bench(SwitchInputRTC("SwitchInputRTC0"), 20.0)
    bench.activate()
    return bench


def test_the_navigation_waits_half_a_second_for_the_hand() -> None:
    bench = switch()
    bench.send("inVelAuto", velocity(0.1))
    bench.run(0.05)
    assert components_of(bench.sent("outVel")) == [(0.1, 0.0)]
    bench.send("inVelJoy", velocity(0.9))
    bench.run(0.05)
    assert components_of(bench.sent("outVel")) == [(0.9, 0.0)]
    passed = []
    for i in range(1, 13):
        bench.send("inVelAuto", velocity(0.1))
        bench.run(0.05)
        passed += [i] * len(bench.sent("outVel"))
    # More than 0.5 s, so the tenth execution after the game pad's still waits.
    assert passed == [11, 12]


def test_without_input_nothing_is_sent() -> None:
    bench = switch()
    bench.run(2.0)
    assert bench.sent("outVel") == []


def test_the_hand_is_passed_on_at_once_and_first() -> None:
    bench = switch()
    bench.send("inVelAuto", velocity(0.1))
    bench.send("inVelJoy", velocity(0.9))
    bench.run(0.05)
    assert components_of(bench.sent("outVel")) == [(0.9, 0.0)]


def pad(tmp_path: Path, text: str) -> Bench:
    (tmp_path / "script").write_text(text, encoding="utf-8")
    bench = Bench(GamePad("GamePad0"), 100.0)
    bench.component.folder = tmp_path
    bench.set(script="script", Klx="0.5", Kly="0.4", Krx="0.3")
    bench.activate()
    return bench


def test_sticks_and_buttons_are_sent_as_they_are_and_as_velocities(
    tmp_path: Path,
) -> None:
    bench = pad(tmp_path, "1 0.25 -0.5 1.0 -1.0 2049\n")
    [sample] = bench.sent("Velocity2DIIS")
    assert (sample.data.vx, sample.data.vy, sample.data.va) == (
        pytest.approx(0.2),
        pytest.approx(-0.125),
        pytest.approx(-0.3),
    )
    [first] = bench.sent("Velocity")
    assert (first.v, first.w) == (pytest.approx(0.2), pytest.approx(-0.3))
    [second] = bench.sent("VelocityIIS")
    assert (second.vx, second.vy, second.w) == (
        pytest.approx(0.2),
        pytest.approx(-0.125),
        pytest.approx(-0.3),
    )
    assert [s.data for s in bench.sent("Button")] == [2049]
    for name, value in (("LX", 0.25), ("LY", -0.5), ("RX", 1.0), ("RY", -1.0)):
        assert [s.data for s in bench.sent(f"Stick{name}")] == [value]
        assert [s.data for s in bench.sent(f"Stick{name}d")] == [value]


def test_a_pad_that_goes_lets_go_of_its_sticks_once(tmp_path: Path) -> None:
    bench = pad(tmp_path, "0.05 0 -1 0 0 0\n")
    bench.run(0.2)
    sent = [s.data for s in bench.sent("StickLYd")]
    assert sent == [-1.0] * 5 + [0.0]
    # The velocity of the third phase is sent only while the pad is connected.
    assert components_of(bench.sent("Velocity2DIIS")) == [(pytest.approx(0.4), 0.0)] * 5
    assert [s.v for s in bench.sent("Velocity")][-1] == 0.0


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"script": "none"}, "script: none: No such file or directory"),
        ({"script": "bad"}, "script: bad:1: "),
    ],
)
def test_a_script_that_is_none(
    tmp_path: Path, parameters: dict[str, str], why: str
) -> None:
    (tmp_path / "bad").write_text("1 2\n", encoding="utf-8")
    bench = Bench(GamePad("GamePad0"), 66.0)
    bench.component.folder = tmp_path
    bench.set(**parameters)
    bench.activate()
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason.startswith(why)


def test_a_device_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pygame", reason="pygame is not installed: the extra joystick")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    bench = Bench(GamePad("GamePad0"), 66.0)
    bench.set(str_port="/dev/input/js99")
    bench.activate()
    assert bench.component.reason == (
        "str_port: there is no game pad /dev/input/js99; 0 found"
    )


def test_sticks_at_rest() -> None:
    assert Sticks() == (0.0, 0.0, 0.0, 0.0, 0)


def scan(noise: str = "0.0", **parameters: str) -> rtc.RangeData:
    bench = Bench(LRFCapture_URG("LRFCapture_URG0"), 10.0)
    bench.component.folder = NAVIGATION
    bench.set(noise=noise, **parameters)
    bench.activate()
    bench.send("pose", pose(0.0, 0.0, pi / 2))
    bench.run(0.1)
    [found] = bench.sent("range")
    assert isinstance(found, rtc.RangeData)
    return found


def test_a_scan_is_that_of_an_urg() -> None:
    found = scan()
    assert found.config.maxRange == 4.0
    assert found.config.frequency == 10.0
    assert found.config.minAngle == pytest.approx(-2 * pi / 3, abs=0.004)
    assert found.config.maxAngle == pytest.approx(2 * pi / 3, abs=0.004)
    assert len(found.ranges) == round(4 * pi / 3 / found.config.angularRes) + 1
    # Straight ahead, from 0.2 m before the axle, is the wall at y = 2.
    assert found.ranges[len(found.ranges) // 2] == pytest.approx(1.8, abs=0.001)
    assert all(reach == 0.0 or 0.02 <= reach <= 4.0 for reach in found.ranges)
    assert 0.0 in scan(angle="3.1").ranges


@pytest.mark.parametrize("module", [obstacle_monitor, disp_position])
def test_of_a_long_way_the_end_is_kept(
    module: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MAX_TRAIL", 2)
    shown = (
        ObstacleMonitor("Shown0")
        if module is obstacle_monitor
        else DispPosition("Shown0")
    )
    bench = Bench(shown, 10.0)
    if module is disp_position:
        bench.set(map_file="")
    bench.activate()
    for x in (1.0, 2.0, 3.0):
        bench.send("position", pose(x, 0.0, 0.0))
        bench.run(0.1)
    assert [at.x for at in shown._trail] == [2.0, 3.0]


def test_noise_is_as_large_as_told_and_the_same_in_each_run() -> None:
    clean, noisy = scan().ranges, scan(noise="0.01").ranges
    errors = [b - a for a, b in zip(clean, noisy, strict=True) if a and b]
    spread = (sum(error * error for error in errors) / len(errors)) ** 0.5
    assert 0.008 < spread < 0.012
    assert noisy == scan(noise="0.01").ranges
    assert noisy != scan(noise="0.01", seed="2").ranges


def test_points_stand_where_the_walls_are() -> None:
    bench = Bench(Urg_to_Obstacles("Urg_to_Obstacles0"), 50.0)
    bench.activate()
    bench.send("range", scan())
    bench.run(0.02)
    [found] = bench.sent("obstacles")
    ahead = [p for p in found.data if abs(atan2(p.y, p.x)) < 0.3]
    assert ahead
    assert all(p.x == pytest.approx(2.0, abs=0.002) for p in ahead)
    gaps = [
        hypot(a.x - b.x, a.y - b.y)
        for a, b in zip(found.data, found.data[1:], strict=False)
    ]
    assert min(gaps) >= 0.02


def avoidance() -> Bench:
    bench = Bench(ObstaclesAvoidance("ObstaclesAvoidance0"), 100.0)
    bench.activate()
    return bench


def driven(bench: Bench, *obstacles: tuple[float, float]) -> tuple[float, float]:
    bench.send("obstacles", points(*obstacles))
    bench.send("velocity_in", velocity(0.3))
    bench.run(0.01)
    [sample] = bench.sent("velocity_out")
    return sample.data.vx, sample.data.va


def test_on_a_free_way_the_velocity_is_passed_on() -> None:
    assert driven(avoidance()) == (0.3, 0.0)
    assert driven(avoidance(), (1.0, 0.9), (3.0, 0.0)) == (0.3, 0.0)


def test_an_obstacle_is_passed_on_the_side_that_is_free() -> None:
    for ahead in (1.4, 1.6, 1.8):
        assert driven(avoidance(), (ahead, 0.1))[1] < 0.0
        assert driven(avoidance(), (ahead, -0.1))[1] > 0.0


def test_before_a_wall_the_base_slows_down_and_stops() -> None:
    wall = [(0.75, 0.05 * i) for i in range(-60, 61)]
    slow, _ = driven(avoidance(), *wall)
    assert 0.0 < slow < 0.3
    assert driven(avoidance(), *[(0.6, y) for _, y in wall])[0] == 0.0


def test_without_scans_the_base_stands() -> None:
    bench = avoidance()
    asked = iis.TimedVelocity2D(data=rtc.Velocity2D(0.3, 0.2, 0.1))
    bench.send("velocity_in", asked)
    bench.run(0.01)
    [sample] = bench.sent("velocity_out")
    assert sample.data == rtc.Velocity2D(0.0, 0.0, 0.0)
    assert driven(bench) == (0.3, 0.0)
    bench.run(0.6)
    bench.send("velocity_in", velocity(0.3))
    bench.run(0.01)
    assert components_of(bench.sent("velocity_out")) == [(0.0, 0.0)]


def test_turning_on_the_spot_and_backing_off_are_passed_on() -> None:
    bench = avoidance()
    bench.send("obstacles", points((0.3, 0.0)))
    for asked in ((0.0, 0.5), (-0.2, 0.0)):
        bench.send("velocity_in", velocity(*asked))
        bench.run(0.01)
        assert components_of(bench.sent("velocity_out")) == [asked]


def test_the_monitor_tells_the_nearest_obstacle() -> None:
    bench = Bench(ObstacleMonitor("ObstacleMonitor0"), 10.0)
    bench.activate()
    assert bench.component.observables["nearest"]() == ()
    bench.send("obstacles", points((3.0, 4.0), (0.0, -2.0)), points())
    bench.run(0.1)
    assert [s.data for s in bench.sent("nearest")] == [2.0]
    assert bench.component.observables["nearest"]() == (2.0,)


def test_a_picture_of_an_unknown_kind() -> None:
    bench = Bench(ObstacleMonitor("ObstacleMonitor0"), 10.0)
    bench.set(picture="seen.gif")
    bench.activate()
    assert bench.component.reason == (
        "picture: seen.gif is not a picture; one of .svg, .png, .pdf"
    )


def test_the_simulated_base_does_what_its_wheels_are_told() -> None:
    bench = Bench(RefHw("RefHw0"), 1000.0)
    bench.set(PlantStart_x="1.0", CommandTimeout="0")
    bench.activate()
    bench.send("WheelSpeed", rtc.TimedDoubleSeq(data=[3.0, 3.0]))
    bench.run(1.0)
    x, y, _ = bench.component.observables["truth"]()
    assert 1.25 < x < 1.3
    assert y == 0.0
    assert bench.sent("pose")[-1].data.position.x == x
    left, right = bench.sent("WheelAngle")[-1].data
    assert left == right == pytest.approx((x - 1.0) / 0.0995, abs=1e-3)
    bench.send("WheelSpeed", rtc.TimedDoubleSeq(data=[1.0]))
    bench.run(0.002)
    assert bench.component.reason == "WheelSpeed: 1 speeds for 2 wheels"


def test_a_way_is_turned_to_on_the_spot() -> None:
    bench = avoidance()
    # A wall close ahead, open to the left.
    wall = [(0.6, 0.05 * i) for i in range(-60, 1)]
    assert driven(bench, *wall) == (0.0, pytest.approx(0.6))
    mirrored = [(x, -y) for x, y in wall]
    assert driven(avoidance(), *mirrored) == (0.0, pytest.approx(-0.6))
    # It does not turn back while it turns.
    assert driven(bench, *mirrored)[1] >= 0.0


def test_the_side_is_turned_to_that_is_free_beside_the_walls() -> None:
    # A corner: once turned to the right, the base would drive along the wall ahead.
    corner = [(0.6, 0.05 * i) for i in range(-60, 13)]
    corner += [(0.05 * i, 0.6) for i in range(-60, 13)]
    assert driven(avoidance(), *corner) == (0.0, pytest.approx(-0.6))
    mirrored = [(x, -y) for x, y in corner]
    assert driven(avoidance(), *mirrored) == (0.0, pytest.approx(0.6))


def test_it_is_reported_when_there_is_no_way() -> None:
    bench = avoidance()
    ring = [(0.6 * cos(0.05 * i), 0.6 * sin(0.05 * i)) for i in range(126)]
    assert driven(bench, *ring) == (0.0, 0.0)
    condition = bench.system.statistics("ObstaclesAvoidance0").condition
    assert condition == "no way ahead, and none to turn to"
    assert driven(bench) == (0.3, 0.0)
    assert bench.system.statistics("ObstaclesAvoidance0").condition == ""


def test_points_move_to_the_side_as_the_base_turns() -> None:
    around = Surroundings(
        Component().add_in_port("o", iis.TimedPoint2DSeq), lambda: 0.0
    )
    around.points = [(1.0, 0.5), (-0.3, -1.0)]
    around.look(SECOND // 2, 0.4, 1.0)
    x, y, theta = advance(0.0, 0.0, 0.0, 0.2, 0.5)
    for (px, py), (mx, my) in zip(
        [(1.0, 0.5), (-0.3, -1.0)], around.points, strict=True
    ):
        # The moved point relative to the present pose of the base.
        assert x + mx * cos(theta) - my * sin(theta) == pytest.approx(px)
        assert y + mx * sin(theta) + my * cos(theta) == pytest.approx(py)
