"""The control components of the four robots, and the four joysticks."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest
from component_bench import Bench

from refnav.aist_joystick import AistJoystick
from refnav.black_ship_control import BlackShipControl
from refnav.joystick_a import JoystickA
from refnav.joystick_b import JoystickB
from refnav.omni_wheel_control import OmniWheelControl
from refnav.ref_hard_control import RefHardControl
from refnav.segway_joystick import SegwayJoystick
from refnav.segway_rmp_control import SegwayRmpControl
from refrobots import iis, rtc
from rtgen.runtime import ACTIVE_STATE, ERROR_STATE, Component

ROBOTS = [RefHardControl, SegwayRmpControl, BlackShipControl, OmniWheelControl]
JOYSTICKS = [JoystickA, JoystickB, SegwayJoystick, AistJoystick]
EVERY_ROBOT = pytest.mark.parametrize("make", ROBOTS)
EVERY_JOYSTICK = pytest.mark.parametrize("make", JOYSTICKS)


def robot(make: type[Component], **parameters: str) -> Bench:
    bench = Bench(make("Robot0"), 100.0)
    bench.set(**parameters)
    bench.activate()
    return bench


def truth(bench: Bench) -> tuple[float, ...]:
    return bench.system.observable("Robot0.truth")


def hold(bench: Bench, port: str, command: object, seconds: float) -> None:
    """Send the same command every 10 ms."""
    for _ in range(round(seconds * 100)):
        bench.send(port, command)
        bench.run(0.01)


@EVERY_ROBOT
def test_a_robot_has_the_interfaces_of_both_phases(make: type[Component]) -> None:
    ports = {(p.kind, p.name): p.type for p in make.profile.ports}
    assert ports == {
        ("inport", "velocity"): "RTC::TimedVelocity",
        ("inport", "moving_command"): "IIS::TimedVelocity",
        ("inport", "target_position"): "IIS::TimedPosition",
        ("outport", "self_position"): "IIS::TimedPosition",
    }


@EVERY_ROBOT
def test_a_robot_goes_by_commands_of_the_first_phase(make: type[Component]) -> None:
    bench = robot(make)
    hold(bench, "velocity", rtc.TimedVelocity(v=0.2, w=0.1), 5.0)
    x, y, theta = truth(bench)
    assert theta == pytest.approx(0.5, abs=0.02)
    assert (x, y) == pytest.approx((0.96, 0.245), abs=0.03)


@EVERY_ROBOT
def test_only_omni_wheels_go_sideways(make: type[Component]) -> None:
    bench = robot(make)
    hold(bench, "moving_command", iis.TimedVelocity(vy=0.2), 2.0)
    expected = 0.4 if make is OmniWheelControl else 0.0
    assert truth(bench) == pytest.approx((0.0, expected, 0.0), abs=0.01)


@EVERY_ROBOT
def test_a_robot_whose_commands_stop_comes_to_rest(make: type[Component]) -> None:
    bench = robot(make)
    hold(bench, "velocity", rtc.TimedVelocity(v=0.3), 1.0)
    bench.run(0.4)
    assert bench.system.observable("Robot0.velocity")[0] == pytest.approx(0.3)
    bench.run(0.4)
    assert bench.system.observable("Robot0.velocity") == (0.0, 0.0, 0.0)


@EVERY_ROBOT
def test_a_robot_tells_where_it_is_and_who_it_is(make: type[Component]) -> None:
    bench = robot(make, robot_id="7", start_x="1", start_y="2", start_theta="0.5")
    hold(bench, "velocity", rtc.TimedVelocity(v=0.3, w=0.2), 3.0)
    positions = bench.sent("self_position")
    assert len(positions) == 301
    assert {tuple(p.id) for p in positions} == {(7,)}
    first, last = positions[0], positions[-1]
    assert (first.x, first.y, first.theta) == (1.0, 2.0, 0.5)
    # By the encoders: near the true pose.
    x, y, theta = truth(bench)
    assert (last.x, last.y, last.theta) != (x, y, theta)
    assert hypot(last.x - x, last.y - y) < 0.005
    assert last.theta == pytest.approx(theta, abs=0.005)
    assert last.tm.sec == 3


@pytest.mark.parametrize("following", ["track", "distance"])
def test_the_newest_input_decides(following: str) -> None:
    bench = robot(RefHardControl, following=following)
    leader = iis.TimedPosition(id=[1], x=3.0)
    bench.send("target_position", leader)
    bench.run(20.0)
    # No new target, so it has gone on to the last one and waits there.
    assert truth(bench)[0] == pytest.approx(2.0, abs=0.02)
    hold(bench, "moving_command", iis.TimedVelocity(vx=-0.2), 2.0)
    bench.run(5.0)
    # The old target is forgotten when the command has ended.
    resting = truth(bench)
    assert resting[0] == pytest.approx(1.5, abs=0.1)
    bench.run(5.0)
    assert truth(bench) == resting
    bench.send("target_position", leader)
    bench.run(10.0)
    assert truth(bench)[0] == pytest.approx(2.0, abs=0.02)


def test_another_leader_is_followed_anew() -> None:
    bench = robot(RefHardControl, following="track")
    for i in range(100):
        bench.send("target_position", iis.TimedPosition(id=[1], x=0.05 * i))
        bench.run(0.01)
    bench.send("target_position", iis.TimedPosition(id=[2], x=0.0, y=2.0))
    bench.run(15.0)
    x, y, _ = truth(bench)
    assert hypot(x, y - 2.0) == pytest.approx(1.0, abs=0.02)


@EVERY_ROBOT
def test_a_robot_that_is_switched_off_stands_where_it_is(make: type[Component]) -> None:
    bench = robot(make)
    hold(bench, "velocity", rtc.TimedVelocity(v=0.3), 2.0)
    bench.deactivate()
    stopped = truth(bench)
    bench.run(1.0)
    bench.activate()
    bench.run(1.0)
    assert truth(bench) == stopped
    assert stopped[0] > 0.5


def joystick(make: type[Component], folder: Path, script: str) -> Bench:
    (folder / "s.txt").write_text(script)
    component = make("Joystick0")
    component.folder = folder
    bench = Bench(component, 50.0)
    bench.set(script="s.txt", max_v="0.4", max_w="0.8")
    bench.activate()
    return bench


@EVERY_JOYSTICK
def test_full_deflection_is_full_speed_in_both_phases(
    make: type[Component], tmp_path: Path
) -> None:
    bench = joystick(make, tmp_path, "1 1 0 -1\n")
    bench.run(0.5)
    first, second = bench.sent("velocity")[-1], bench.sent("moving_command")[-1]
    assert (first.v, first.w) == (0.4, -0.8)
    assert (second.vx, second.vy, second.w) == (0.4, 0.0, -0.8)
    assert (first.tm.sec, first.tm.nsec) == (second.tm.sec, second.tm.nsec) != (0, 0)


@EVERY_JOYSTICK
def test_commands_go_out_while_the_stick_is_held_and_once_when_let_go(
    make: type[Component], tmp_path: Path
) -> None:
    bench = joystick(make, tmp_path, "1 0 0 0\n1 1 0 0\n5 0 0 0\n")
    bench.run(5.0)
    speeds = [sample.v for sample in bench.sent("velocity")]
    assert speeds == [0.4] * 50 + [0.0]


@pytest.mark.parametrize(
    ("make", "speed", "left"),
    [
        (JoystickA, 0.24, 0.0),
        (JoystickB, 0.24, 0.12),
        (SegwayJoystick, 0.144, 0.0),
        (AistJoystick, 0.4, 0.0),
    ],
)
def test_each_joystick_answers_in_its_own_way(
    make: type[Component], speed: float, left: float, tmp_path: Path
) -> None:
    bench = joystick(make, tmp_path, "1 0.6 0.3 0.04\n")
    bench.run(0.5)
    sample = bench.sent("moving_command")[-1]
    assert (sample.vx, sample.vy) == pytest.approx((speed, left))
    assert sample.w == pytest.approx(0.0, abs=0.01)


@EVERY_JOYSTICK
def test_without_a_script_nobody_touches_the_stick(make: type[Component]) -> None:
    bench = Bench(make("Joystick0"), 50.0)
    bench.activate()
    bench.run(1.0)
    assert bench.state is ACTIVE_STATE
    assert bench.sent("velocity") == []


@pytest.mark.parametrize("text", [None, "1 2 0 0", "\xff"])
def test_a_script_that_cannot_be_used_is_an_error(
    text: str | None, tmp_path: Path
) -> None:
    component = JoystickA("Joystick0")
    component.folder = tmp_path
    if text is not None:
        (tmp_path / "s.txt").write_bytes(text.encode("latin-1"))
    bench = Bench(component, 50.0)
    bench.set(script="s.txt")
    bench.activate()
    assert bench.state is ERROR_STATE
    assert bench.system.statistics("Joystick0").reason.startswith("script: ")
