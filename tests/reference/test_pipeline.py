"""The whole pipeline under disturbance, and its other inputs."""

from __future__ import annotations

import io
import shutil
from itertools import pairwise
from math import hypot
from pathlib import Path

import pytest
from pipeline import (
    GOAL,
    MAX_DURATION,
    NAVIGATION,
    PATH,
    at_end,
    build,
    goal,
    profile,
    truth,
)

from refnav.geometry import Pose, wrap
from refrobots import RefHard
from rtgen.runtime import (
    ACTIVE_STATE,
    INACTIVE_STATE,
    SECOND,
    Component,
    JsonLinesRecorder,
    System,
)


def assert_at(pose: Pose, x: float, y: float, theta: float) -> None:
    assert hypot(pose.x - x, pose.y - y) < 0.05
    assert abs(wrap(pose.theta - theta)) < 0.03


def run_for(system: System, seconds: float) -> None:
    system.run(system.time + round(seconds * SECOND))


@pytest.mark.parametrize("file", [GOAL, PATH])
def test_the_ten_connections(file: Path) -> None:
    ends = [(str(c.source), str(c.target)) for c in profile(file).connections]
    assert sorted(ends) == sorted(
        [
            ("PositionInput0..positon", "OmniTo2WD0.goal"),
            ("OmniTo2WD0.min_path", "Navigation0.min_path"),
            ("Navigation0.path", "PathFollower0.target_path"),
            ("PathFollower0.velocity", "RefHardRh30.InTargetVelocity"),
            ("RefHardRh30.OutWheelAngle", "Odometry0.CurrentWheelAngle"),
            ("Odometry0.OdometryPosition", "OmniTo2WD0.current_position"),
            ("Odometry0.OdometryPosition", "Navigation0.position"),
            ("Odometry0.OdometryPosition", "PathFollower0.position"),
            ("Navigation0.status", "OmniTo2WD0.status"),
            ("OmniTo2WD0.status", "PositionInput0.status"),
        ]
    )


@pytest.mark.sampled(0)
def test_two_runs_give_the_same_log() -> None:
    logs = []
    for _ in range(2):
        stream = io.StringIO()
        with build(profile(), goal(0.3, 0.1, 0.5)) as system:
            system.add_listener(JsonLinesRecorder(stream))
            assert system.run(MAX_DURATION, at_end)
        logs.append(stream.getvalue())
    assert logs[0] == logs[1]
    assert logs[0].count("\n") > 1000


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "target", [(-1.0, 0.5, 0.0), (0.0, 0.0, 2.5), (1.0, -1.0, -3.0)]
)
def test_goals_all_round(target: tuple[float, float, float]) -> None:
    with build(profile(), goal(*target)) as system:
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), *target)


def test_wheels_keep_their_limits() -> None:
    limits = ["RefHardRh30.Velocity_limit=2.5", "RefHardRh30.Acceleration_limit=20.0"]
    with build(profile(), [*goal(1.0, 1.0, 0.0), *limits]) as system:
        speeds: list[tuple[float, ...]] = []
        system.every(
            SECOND // 1000,
            lambda: speeds.append(system.observable("RefHardRh30.wheels")),
        )
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 1.0, 1.0, 0.0)
    for wheel in zip(*speeds, strict=True):
        assert max(map(abs, wheel)) == 2.5
        assert max(abs(b - a) for a, b in pairwise(wheel)) <= 20.0 * 0.001 + 1e-9


def test_deactivating_odometry_brings_back_the_initial_pose() -> None:
    with build(profile()) as system:
        system.run(10 * SECOND)
        assert hypot(*truth(system)[:2]) > 0.5
        system.deactivate("Navigation0")
        system.deactivate("PathFollower0")
        system.deactivate("Odometry0")
        run_for(system, 0.1)
        assert system.state("Odometry0") is INACTIVE_STATE
        poses = []
        system.configure("Odometry0", "initialPose_x", "5.0")
        system.activate("Odometry0")
        system.add_listener(lambda record: poses.append(record))
        run_for(system, 0.5)
        samples = [
            r.value.data
            for r in poses
            if r.kind == "sample" and r.port == "OdometryPosition"
        ]
        assert len(samples) > 40
        assert {(p.position.x, p.position.y, p.heading) for p in samples} == {
            (5.0, 0.0, 0.0)
        }


class Operator(Component):
    """Calls the two services of the base."""

    def __init__(self) -> None:
        super().__init__("Operator0")
        self.panel = self.add_consumer("panel", "RefHard", RefHard)
        self.bumper = self.add_consumer("bumper", "RefHard", RefHard)


def test_stop_halts_the_base_and_go_lets_it_reach_its_goal() -> None:
    operator = Operator()
    with build(profile(), goal(1.0, 0.5, 0.5)) as system:
        system.add(operator, 10.0)
        system.connect(("Operator0", "panel"), ("RefHardRh30", "InventGUIRefHard"))
        system.connect(("Operator0", "bumper"), ("RefHardRh30", "BumpRefHard"))
        run_for(system, 3.0)
        assert max(map(abs, system.observable("RefHardRh30.wheels"))) > 1.0
        operator.bumper.object.Stop()
        run_for(system, 0.5)
        halted = truth(system)
        run_for(system, 5.0)
        assert truth(system) == halted
        assert system.observable("RefHardRh30.wheels") == (0.0, 0.0)
        operator.panel.object.Go()
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 1.0, 0.5, 0.5)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "name",
    [
        "PathFollower0.velocity_RefHardRh30.InTargetVelocity",
        "RefHardRh30.OutWheelAngle_Odometry0.CurrentWheelAngle",
    ],
)
def test_a_connection_cut_and_made_again_while_active(name: str) -> None:
    with build(profile(), goal(1.0, 0.5, 0.5)) as system:
        [connection] = [c for c in profile().connections if c.name == name]
        run_for(system, 2.0)
        system.disconnect(name)
        run_for(system, 0.3)
        system.connect(
            (connection.source.instance, connection.source.port),
            (connection.target.instance, connection.target.port),
            dict(connection.properties),
            name,
        )
        assert all(system.state(i) is ACTIVE_STATE for i in system.instances)
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 1.0, 0.5, 0.5)


def test_without_commands_the_base_comes_to_rest() -> None:
    with build(profile()) as system:
        run_for(system, 3.0)
        system.disconnect("PathFollower0.velocity_RefHardRh30.InTargetVelocity")
        run_for(system, 2.0)
        assert system.observable("RefHardRh30.wheels") == (0.0, 0.0)


def test_odometry_conf_overrides_the_definition(tmp_path: Path) -> None:
    for file in ("rh3_goal.xml", "Odometry.conf"):
        shutil.copy(NAVIGATION / file, tmp_path)
    conf = tmp_path / "Odometry.conf"
    text = conf.read_text(encoding="utf-8").replace(
        "initialPose_x: 0.0", "initialPose_x: 1.0"
    )
    conf.write_text(text, encoding="utf-8")
    with build(profile(tmp_path / "rh3_goal.xml"), goal(1.5, 0.0, 0.5)) as system:
        assert system.run(MAX_DURATION, at_end)
        # The odometry assumes a start 1 m farther on than the true one.
        assert_at(truth(system), 0.5, 0.0, 0.5)


def test_fifty_waypoints_go_through_the_goal_connector(tmp_path: Path) -> None:
    points = [(0.2 * k, 0.0, 0.0) for k in range(1, 50)] + [(9.8, 0.5, 1.0)]
    commands = tmp_path / "tour.txt"
    commands.write_text(
        "path " + "; ".join(f"{x} {y} {t}" for x, y, t in points) + "\n"
    )
    settings = [f"PositionInput0.input_file={commands}"]
    with build(profile(PATH), settings) as system:
        plans = []
        system.add_listener(
            lambda r: (
                plans.append(r.value) if getattr(r, "port", "") == "min_path" else None
            )
        )
        run_for(system, 0.5)
        [plan] = plans
        assert [(p.position.x, p.position.y) for p in plan.pose[2::2]][:50] == [
            point[:2] for point in points
        ]
        assert all(system.statistics(i).lost == 0 for i in system.instances)


@pytest.mark.sampled(0)
def test_two_commands_of_a_file_one_after_the_other(tmp_path: Path) -> None:
    commands = tmp_path / "tour.txt"
    commands.write_text("goal 0.3 0 1.0\ngoal 0.3 0.3 0.0\n")
    with build(profile(PATH), [f"PositionInput0.input_file={commands}"]) as system:
        finishes = []
        system.add_listener(
            lambda r: (
                finishes.append(truth(system))
                if r.kind == "sample"
                and (r.instance, r.port) == ("OmniTo2WD0", "status")
                else None
            )
        )
        assert system.run(MAX_DURATION, at_end)
        first, second = finishes
        assert_at(first, 0.3, 0.0, 1.0)
        assert_at(second, 0.3, 0.3, 0.0)


def test_a_goal_from_the_console() -> None:
    with build(profile(), ["PositionInput0.input=console"]) as system:
        component = system.component("PositionInput0")
        component.console = io.StringIO("goal 0.3 0.0 0.5\n")
        run_for(system, 0.05)
        component.console_reader.wait_for_end()
        assert system.run(MAX_DURATION, at_end)
        assert_at(truth(system), 0.3, 0.0, 0.5)
