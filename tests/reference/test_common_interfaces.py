"""The rules of the common interfaces, third phase: each test names its rule.

Rules are numbered as in the sections on the target path, the travel command and information, the
self-position, the target list and the travel state: 4.4 to 4.8.
"""

from __future__ import annotations

from math import cos, dist, hypot, pi, sin, tau
from pathlib import Path
from typing import Any

import pytest
from component_bench import Bench

from refnav.geometry import wrap
from refnav.odometry import Odometry
from refnav.path_tracking import PathTracking
from refnav.planning_manager import PlanningManager
from refnav.travel_control import BODIES, TravelControl
from refnav.travel_odometry import TravelOdometry
from refnav.user_interface import UserInterface
from refrobots import iis, rtc
from rtgen.runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    SECOND,
    Component,
    SimulatedClock,
    System,
)

Poses = list[tuple[float, float, float]]


def pose(x: float, y: float, theta: float = 0.0) -> rtc.Pose2D:
    return rtc.Pose2D(rtc.Point2D(x, y), theta)


def path(poses: Poses, speeds: list[float] | None = None) -> iis.TimedPath2DSeq:
    return iis.TimedPath2DSeq(
        pose=[pose(*p) for p in poses],
        velocity=[rtc.Velocity2D(v, 0.0, 0.0) for v in speeds or []],
    )


def targets(*poses: tuple[float, float, float]) -> iis.TimedPose2DSeq:
    return iis.TimedPose2DSeq(data=[pose(*p) for p in poses])


class Operator(Component):
    """Stand-in for everything not under test: sends by hand, records what arrives."""


class Robot:
    """PathTracking, TravelControl and TravelOdometry, and an operator at every open port."""

    def __init__(self, robot: str = "RefHard", *, planned: bool = False) -> None:
        self.system = System(SimulatedClock())
        self.operator = Operator("Operator0")
        self.operator.add_out_port("path", iis.TimedPath2DSeq)
        self.operator.add_out_port("targets", iis.TimedPose2DSeq)
        self.operator.add_in_port("state", iis.TimedPose2D)
        self.operator.add_in_port("planned", iis.TimedPath2DSeq)
        self.system.add(self.operator, 100.0)
        for component in (
            *((PlanningManager("Planning0"),) if planned else ()),
            PathTracking("Tracking0"),
            TravelControl("Control0"),
            TravelOdometry("Odometry0"),
        ):
            self.system.add(component)
        self.system.configure("Control0", "robot", robot)
        self.join("Tracking0.command", "Control0.command")
        self.join("Control0.information", "Odometry0.information")
        self.join("Odometry0.position", "Tracking0.position")
        self.join("Tracking0.state", "Operator0.state")
        if planned:
            self.join("Operator0.targets", "Planning0.targets")
            self.join("Odometry0.position", "Planning0.position")
            self.join("Tracking0.state", "Planning0.state")
            self.join("Planning0.path", "Tracking0.path")
            self.join("Planning0.path", "Operator0.planned")
        else:
            self.join("Operator0.path", "Tracking0.path")
        for instance in self.system.instances:
            self.system.activate(instance)
        self.track: Poses = []
        self.system.every(SECOND // 50, self._look)
        self.run(0.05)

    def join(self, source: str, target: str) -> None:
        one, _, out_port = source.partition(".")
        other, _, in_port = target.partition(".")
        length = {"dataport.inport.buffer.length": "1000"}
        self.system.connect((one, out_port), (other, in_port), length)

    def _look(self) -> None:
        found = self.system.observable("Control0.truth")
        if found:
            self.track.append((found[0], found[1], found[2]))

    def run(self, seconds: float) -> None:
        self.system.run(self.system.time + round(seconds * SECOND))

    def send(self, port: str, value: Any) -> None:
        self.operator.out_ports[port].write(value)

    def received(self, port: str) -> list[Any]:
        found = []
        while self.operator.in_ports[port].is_new():
            found.append(self.operator.in_ports[port].read())
        return found

    def states(self) -> list[tuple[int, int]]:
        return [(state.id[0], state.id[1]) for state in self.received("state")]

    @property
    def truth(self) -> tuple[float, float, float]:
        return self.track[-1]


def off(robot: Robot, x: float, y: float) -> float:
    return dist(robot.truth[:2], (x, y))


# 4.4, target path.


@pytest.mark.parametrize("count", [2, 3, 200])
def test_4_4_1_any_number_of_waypoints_in_world_coordinates(count: int) -> None:
    robot = Robot()
    angles = [pi * i / (count - 1) for i in range(count)]
    arc = [(sin(a), 1.0 - cos(a), a) for a in angles]
    robot.send("path", path(arc))
    robot.run(30.0)
    assert off(robot, 0.0, 2.0) < 0.05
    assert robot.states()[-1] == (count - 1, 1)


def test_4_4_2_a_negative_vx_asks_for_backward_travel() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (-1, 0, 0)], [0.0, -0.2]))
    robot.run(15.0)
    assert off(robot, -1.0, 0.0) < 0.05
    # It has never turned round.
    assert max(abs(theta) for _, _, theta in robot.track) < 0.1


def test_4_4_2_each_leg_has_its_own_direction() -> None:
    robot = Robot()
    there_and_back = [(0, 0, 0), (1, 0, 0), (0, 0, 0)]
    robot.send("path", path(there_and_back, [0.0, 0.3, -0.3]))
    robot.run(20.0)
    assert off(robot, 0.0, 0.0) < 0.05
    assert max(x for x, _, _ in robot.track) > 0.9
    assert max(abs(theta) for _, _, theta in robot.track) < 0.1


def test_4_4_3_only_the_heading_of_the_last_waypoint_counts() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 3.0), (1, 0, -2.0), (2, 0, 1.0)]))
    robot.run(7.0)
    assert max(abs(theta) for _, _, theta in robot.track) < 0.1
    robot.run(10.0)
    assert abs(wrap(robot.truth[2] - 1.0)) < 0.03


@pytest.mark.parametrize("sent", [(0.2, 0.5, 0.0), (0.2, 0.0, 2.0)])
def test_4_4_4_velocity_components_beside_vx_may_be_ignored(
    sent: tuple[float, float, float],
) -> None:
    robot = Robot()
    wanted = path([(0, 0, 0), (1, 0, 0)])
    wanted.velocity = [rtc.Velocity2D(*sent), rtc.Velocity2D(*sent)]
    robot.send("path", wanted)
    robot.run(2.5)
    (x, y, _), (later, _, _) = robot.track[-51], robot.track[-1]
    assert later - x == pytest.approx(0.2, abs=0.01)
    assert abs(y) < 0.01
    robot.run(10.0)
    assert off(robot, 1.0, 0.0) < 0.05


def test_4_4_5_a_new_list_takes_the_place_of_the_old_one() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (3, 0, 0)]))
    robot.run(3.0)
    x = robot.truth[0]
    robot.send("path", path([(x, 0, 0), (x + 0.5, 1, 0), (x, 2, 0)]))
    robot.run(20.0)
    assert off(robot, x, 2.0) < 0.05
    assert max(x for x, _, _ in robot.track) < 2.0


def test_4_4_6_an_empty_list_stops_the_robot_there() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (3, 0, 0)]))
    robot.run(3.0)
    before = robot.truth
    robot.send("path", path([]))
    robot.run(0.5)
    stopped = robot.truth
    robot.run(5.0)
    assert dist(before[:2], stopped[:2]) < 0.1
    assert robot.truth == stopped


def test_4_4_7_the_first_element_is_the_start_so_one_waypoint_moves_nothing() -> None:
    robot = Robot()
    robot.send("path", path([(1, 0, 0)]))
    robot.run(5.0)
    assert robot.truth == (0.0, 0.0, 0.0)
    robot.send("path", path([(0, 0, 0), (1, 0, 0)]))
    robot.run(10.0)
    assert off(robot, 1.0, 0.0) < 0.05


def test_4_4_8_a_robot_that_stands_elsewhere_is_led_onto_the_first_leg() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0.5, 0), (3, 0.5, 0)]))
    robot.run(20.0)
    assert off(robot, 3.0, 0.5) < 0.05
    assert all(abs(y - 0.5) < 0.1 for x, y, _ in robot.track if x > 1.5)


def test_4_4_9_between_two_waypoints_the_path_is_straight() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (2, 2, 0)]))
    robot.run(20.0)
    assert off(robot, 2.0, 2.0) < 0.05
    assert max(abs(x - y) / hypot(1, 1) for x, y, _ in robot.track) < 0.1


class Pusher(Component):
    """A component between path tracking and travel control that steers aside for a while."""

    def on_execute(self, ec_id: int) -> Any:
        command = self.in_ports["input"].read_newest()
        if command is not None:
            if 4.0 < self.now() / SECOND < 5.5:
                command.data.va += 0.8
            self.out_ports["output"].write(command)
        return super().on_execute(ec_id)


def test_4_4_10_the_path_is_nominal_and_modules_behind_may_leave_it() -> None:
    robot = Robot()
    pusher = Pusher("Pusher0")
    pusher.add_in_port("input", iis.TimedVelocity2D)
    pusher.add_out_port("output", iis.TimedVelocity2D)
    robot.system.add(pusher, 100.0)
    robot.system.activate("Pusher0")
    robot.system.disconnect("Tracking0.command_Control0.command")
    robot.join("Tracking0.command", "Pusher0.input")
    robot.join("Pusher0.output", "Control0.command")
    robot.send("path", path([(0, 0, 0), (4, 0, 0)]))
    robot.run(30.0)
    assert max(abs(y) for _, y, _ in robot.track) > 0.05
    assert off(robot, 4.0, 0.0) < 0.05


def test_4_4_11_poses_and_velocities_match_in_length() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 0)], [0.1]))
    robot.run(0.05)
    assert robot.system.state("Tracking0") is ERROR_STATE
    assert "1 velocities for 2 waypoints" in robot.system.statistics("Tracking0").reason
    robot.run(1.0)
    assert robot.truth == (0.0, 0.0, 0.0)


def test_4_4_11_the_speed_is_that_of_the_leg_which_ends_at_the_waypoint() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 0), (3, 0, 0)], [9.0, 0.1, 0.3]))
    robot.run(20.0)
    speeds = {
        x: (later - x) * 50.0
        for (x, _, _), (later, _, _) in zip(robot.track, robot.track[1:], strict=False)
    }
    first = [v for x, v in speeds.items() if 0.2 < x < 0.8]
    second = [v for x, v in speeds.items() if 1.2 < x < 2.5]
    assert first == pytest.approx([0.1] * len(first), abs=0.005)
    assert second == pytest.approx([0.3] * len(second), abs=0.005)


# 4.5, travel command and travel information.


def test_4_5_1_commands_go_to_travel_control_and_information_to_odometry() -> None:
    command, information = "IIS::TimedVelocity2D", "IIS::TimedVelocity2D"
    ports = {
        component: {(p.kind, p.name): p.type for p in component.profile.ports}
        for component in (PathTracking, TravelControl, TravelOdometry)
    }
    assert ports[PathTracking]["outport", "command"] == command
    assert ports[TravelControl]["inport", "command"] == command
    assert ports[TravelControl]["outport", "information"] == information
    assert ports[TravelOdometry]["inport", "information"] == information


def command(
    vx: float, vy: float = 0.0, va: float = 0.0, *, sec: int = 0, nsec: int = 1
) -> iis.TimedVelocity2D:
    return iis.TimedVelocity2D(tm=rtc.Time(sec, nsec), data=rtc.Velocity2D(vx, vy, va))


def controlled(robot: str, **parameters: str) -> Bench:
    bench = Bench(TravelControl("Control0"), 100.0)
    bench.set(robot=robot, CommandTimeout="0", **parameters)
    bench.activate()
    return bench


def test_4_5_2_velocities_are_in_the_frame_of_the_robot() -> None:
    bench = controlled("OmniWheel", start_theta="1.5707963267948966")
    bench.send("command", command(0.2, 0.1, 0.0))
    bench.run(2.0)
    x, y, theta = bench.system.observable("Control0.truth")
    # Forward is along y, left is along -x.
    assert (x, y, theta) == pytest.approx((-0.2, 0.4, pi / 2), abs=0.02)
    data = bench.sent("information")[-1].data
    assert (data.vx, data.vy, data.va) == pytest.approx((0.2, 0.1, 0.0), abs=0.03)


@pytest.mark.parametrize("robot", BODIES)
def test_4_5_2_vx_is_forward_and_va_counter_clockwise(robot: str) -> None:
    bench = controlled(robot)
    bench.send("command", command(0.2, 0.0, 0.3))
    bench.run(3.0)
    x, y, theta = bench.system.observable("Control0.truth")
    assert theta == pytest.approx(0.9, abs=0.05)
    assert (x, y) == pytest.approx((sin(0.9) / 1.5, (1 - cos(0.9)) / 1.5), abs=0.03)


def test_4_5_3_commands_carry_their_time() -> None:
    bench = controlled("RefHard")
    bench.send("command", command(0.2, nsec=0))
    bench.run(1.0)
    assert bench.system.observable("Control0.truth")[0] == 0.0
    bench.send("command", command(0.2, nsec=1))
    bench.run(1.0)
    assert bench.system.observable("Control0.truth")[0] > 0.15


def test_4_5_3_a_command_that_is_too_old_is_not_carried_out() -> None:
    bench = controlled("RefHard")
    bench.set(CommandTimeout="0.5")
    bench.run(2.0)
    bench.send("command", command(0.2, sec=1))
    bench.run(1.0)
    assert bench.system.observable("Control0.truth")[0] == 0.0


def test_4_5_3_what_is_sent_has_its_time() -> None:
    robot = Robot()
    robot.operator.add_in_port("velocities", iis.TimedVelocity2D)
    robot.join("Tracking0.command", "Operator0.velocities")
    robot.join("Control0.information", "Operator0.velocities")
    robot.run(1.0)
    stamps = [v.tm.sec * SECOND + v.tm.nsec for v in robot.received("velocities")]
    assert len(stamps) == 200
    assert stamps == sorted(stamps)
    assert 0.9 * SECOND < stamps[-1] - stamps[0] < SECOND


@pytest.mark.parametrize(
    ("component", "port"), [(PathTracking, "command"), (TravelControl, "information")]
)
def test_4_5_4_velocities_are_sent_every_10_ms(
    component: type[Component], port: str
) -> None:
    assert component.profile.rate is not None
    assert component.profile.rate >= 100.0
    rate = component.profile.rate
    bench = Bench(component("Sender0"), rate)
    bench.activate()
    bench.sent(port)
    bench.run(1.0)
    assert len(bench.sent(port)) == rate


# 4.6, self-position.


def test_4_6_the_self_position_goes_to_tracking_and_planning_in_world_coordinates() -> (
    None
):
    bench = Bench(TravelOdometry("Odometry0"), 100.0)
    bench.set(start_x="1", start_y="2", start_theta="3.141592653589793")
    bench.set(InformationTimeout="0")
    bench.activate()
    bench.send("information", command(0.5, 0.0, 0.0, sec=2))
    bench.run(0.02)
    [position] = bench.sent("position")
    assert (position.tm.sec, position.tm.nsec) == (2, 1)
    assert position.data.position.x == pytest.approx(0.0, abs=0.01)
    assert position.data.position.y == pytest.approx(2.0, abs=0.01)
    assert position.data.heading == pytest.approx(pi)
    for component in (PathTracking, PlanningManager):
        ports = {(p.kind, p.name): p.type for p in component.profile.ports}
        assert ports["inport", "position"] == "IIS::TimedPose2D"


def test_4_6_all_information_counts_and_none_twice() -> None:
    bench = Bench(TravelOdometry("Odometry0"), 100.0)
    bench.set(InformationTimeout="0")
    bench.activate()
    samples = [command(1.0, nsec=500_000_000 * i) for i in (1, 2)]
    samples += [command(1.0, sec=2), command(9.0, sec=2), command(9.0, sec=1)]
    bench.send("information", *samples)
    bench.run(0.02)
    assert bench.sent("position")[-1].data.position.x == pytest.approx(2.0, abs=0.02)


# 4.7, target list.


def test_4_7_1_the_user_interface_sends_targets_in_world_coordinates(
    tmp_path: Path,
) -> None:
    (tmp_path / "t.txt").write_text("0.2 1 2 -1.5; 3 4 0\n0.5 clear # enough\n")
    interface = UserInterface("Interface0")
    interface.folder = tmp_path
    bench = Bench(interface, 10.0)
    bench.set(script="t.txt")
    bench.activate()
    bench.run(1.0)
    first, second = bench.sent("targets")
    assert [p.position.x for p in first.data] == [1.0, 3.0]
    assert first.data[0].heading == pytest.approx(tau - 1.5)
    assert second.data == []


@pytest.mark.parametrize(
    "text", ["", "1 2 3", "x 1 2 3", "1 1 2 nan", "2 clear\n1 clear", "-1 clear"]
)
def test_4_7_1_a_script_that_is_not_understood_is_an_error(
    tmp_path: Path, text: str
) -> None:
    (tmp_path / "t.txt").write_text(text)
    interface = UserInterface("Interface0")
    interface.folder = tmp_path
    bench = Bench(interface, 10.0)
    bench.set(script="t.txt")
    bench.activate()
    assert bench.state is ERROR_STATE
    assert bench.system.statistics("Interface0").reason.startswith("script: t.txt")


def test_4_7_2_only_the_first_target_counts() -> None:
    robot = Robot(planned=True)
    robot.send("targets", targets((1, 0, 0), (5, 5, 0), (9, 9, 0)))
    robot.run(10.0)
    assert off(robot, 1.0, 0.0) < 0.05
    assert robot.system.observable("Planning0.goal") == (1.0, 0.0, 0.0)


def test_4_7_3_a_new_target_list_takes_the_place_of_the_old_one() -> None:
    robot = Robot(planned=True)
    robot.send("targets", targets((3, 0, 0)))
    robot.run(3.0)
    robot.send("targets", targets((1, 1, 0)))
    robot.run(15.0)
    assert off(robot, 1.0, 1.0) < 0.05
    first, second = robot.received("planned")
    assert first.pose[-1].position.x == 3.0
    assert second.pose[0].position.x == pytest.approx(0.8, abs=0.2)


def test_4_7_4_an_empty_target_list_clears_the_target_and_stops_at_the_spot() -> None:
    robot = Robot(planned=True)
    robot.send("targets", targets((3, 0, 0)))
    robot.run(3.0)
    robot.send("targets", targets())
    robot.run(1.0)
    stopped = robot.truth
    robot.run(5.0)
    assert robot.truth == stopped
    assert 0.3 < stopped[0] < 1.5
    assert robot.system.observable("Planning0.goal") == ()
    assert robot.received("planned")[-1].pose == []


# 4.8, travel state.


def test_4_8_1_the_state_goes_from_tracking_to_planning() -> None:
    robot = Robot(planned=True)
    assert robot.system.observable("Planning0.travel") == ()
    robot.send("targets", targets((1, 0, 0)))
    robot.run(10.0)
    assert robot.system.observable("Planning0.travel") == (1.0, 1.0)


def test_4_8_1_planning_refuses_a_state_without_number_and_flag() -> None:
    bench = Bench(PlanningManager("Planning0"), 50.0)
    bench.activate()
    bench.send("state", iis.TimedPose2D(id=[1]))
    bench.run(0.05)
    assert bench.state is ERROR_STATE


def test_4_8_2_the_state_has_the_waypoint_and_whether_the_robot_travels() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 0), (1, 1, 6.0)]))
    robot.run(20.0)
    for state in robot.received("state"):
        number, stopped = state.id
        assert stopped in (0, 1)
        assert (state.data.position.x, state.data.position.y) == (
            [(0, 0), (1, 0), (1, 1)][number]
        )
        assert state.tm.sec > 0


def test_4_8_3_every_waypoint_is_reported_when_it_is_passed() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0)]))
    passed: dict[int, tuple[float, float, float]] = {}
    for _ in range(200):
        robot.run(0.1)
        for number, stopped in robot.states():
            if not stopped:
                passed[number] = robot.truth
    assert [*passed] == [1, 2, 3]
    for number, place in ((1, (1.0, 0.0)), (2, (2.0, 0.0)), (3, (2.0, 1.0))):
        assert dist(passed[number][:2], place) < 0.1


def test_4_8_4_a_stop_is_flagged_with_the_waypoint_reached_last() -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 0), (3, 0, 0)]))
    robot.run(6.0)
    robot.send("path", path([]))
    robot.run(2.0)
    assert robot.states() == [(1, 0), (1, 1)]
    still = robot.truth
    robot.run(1.0)
    assert robot.truth == still


# 4.3, angles, for every interface; and all of Figure 103.


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
def test_4_3_any_angle_is_understood(turns: int) -> None:
    robot = Robot()
    robot.send("path", path([(0, 0, 0), (1, 0, 2.0 + tau * turns)]))
    robot.run(12.0)
    assert abs(wrap(robot.truth[2] - 2.0)) < 0.03


def test_4_3_the_third_phase_writes_angles_from_0_to_2_pi() -> None:
    robot = Robot(planned=True)
    robot.operator.add_in_port("position", iis.TimedPose2D)
    robot.join("Odometry0.position", "Operator0.position")
    robot.send("targets", targets((-0.5, -0.5, -1.0)))
    robot.run(15.0)
    headings = [p.data.heading for p in robot.received("position")]
    headings += [s.data.heading for s in robot.received("state")]
    headings += [p.heading for sent in robot.received("planned") for p in sent.pose]
    assert len(headings) > 1000
    assert all(0.0 <= heading < tau for heading in headings)
    assert max(headings) > pi


def test_4_3_the_navigation_pipeline_writes_angles_from_minus_pi_to_pi() -> None:
    bench = Bench(Odometry("Odometry0"), 100.0)
    bench.set(initialPose_theta="3.0")
    bench.activate()
    for i in range(1, 200):
        turned = rtc.TimedDoubleSeq(rtc.Time(i, 0), [-0.1 * i, 0.1 * i])
        bench.send("CurrentWheelAngle", turned)
        bench.run(0.01)
    headings = [p.data.heading for p in bench.sent("OdometryPosition")]
    assert all(-pi <= heading <= pi for heading in headings)
    assert min(headings) < -3.0
    assert max(headings) > 3.0


@pytest.mark.parametrize("kind", BODIES)
def test_any_robot_is_driven_by_the_modules_of_the_third_phase(kind: str) -> None:
    robot = Robot(kind, planned=True)
    robot.send("targets", targets((1.0, 0.5, 1.0)))
    robot.run(15.0)
    assert off(robot, 1.0, 0.5) < 0.05
    assert abs(wrap(robot.truth[2] - 1.0)) < 0.05
    assert all(
        robot.system.state(instance) is ACTIVE_STATE
        for instance in robot.system.instances
    )
    assert robot.states()[-1] == (1, 1)
