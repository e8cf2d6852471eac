"""Adapters between data of RT-Middleware and messages of ROS 2: both ways, units, constants."""

from __future__ import annotations

import math
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from adapter_peer import connected
from hypothesis import given
from hypothesis import strategies as st

from rtgen.cli import run
from rtgen.facts.ros_adapters import PAIRS, pair_of
from rtgen.runtime import ACTIVE_STATE, ERROR_STATE, PortStatus, SimulatedClock, System
from rtgen.runtime.ports.data_ports import DataConnector, OutPort
from rtgen.runtime.ros2 import conversions

IDL = """
#include "InterfaceDataTypes.idl"
#include "geometry_msgs/msg/PoseStamped.idl"
#include "geometry_msgs/msg/TwistStamped.idl"
#include "nav_msgs/msg/Odometry.idl"
#include "sensor_msgs/msg/LaserScan.idl"
#include "sensor_msgs/msg/JointState.idl"
#include "nav_msgs/msg/OccupancyGrid.idl"
module RTC {
    struct OccupancyGridMap { Time tm; OGMapConfig config; OGMapTile map; };
};
"""
CONSTANTS = {
    "nav_msgs::msg::Odometry": '"header.frame_id" = "odom", "child_frame_id" = "base \\"link\\"", '
    f'"pose.covariance" = {[0.25] * 36}, twist.twist.linear.z = 1',
    "sensor_msgs::msg::JointState": 'name = ["left", "right"]',
    "sensor_msgs::msg::LaserScan": '"time_increment" = 0.5',
}


def table(name: str, from_: str, to: str, more: str = "") -> str:
    return f'[adapter.{name}]\nfrom = "{from_}"\nto = "{to}"\n{more}\n'


@pytest.fixture(scope="module")
def adapters(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    """Import the generated package with all pairs: `To0`, `From0` and so on."""
    folder = tmp_path_factory.mktemp("adapters")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("t.idl").write_text(IDL)
        tables = []
        for number, pair in enumerate(PAIRS):
            constants = CONSTANTS.get(pair.ros)
            more = f"set = {{ {constants} }}" if constants else ""
            tables.append(table(f"To{number}", f"RTC::{pair.rtm}", pair.ros, more))
            tables.append(table(f"From{number}", pair.ros, f"RTC::{pair.rtm}"))
        Path("rtgen.toml").write_text(
            '[sources]\npaths = ["t.idl"]\n[output]\npackage = "ros_adapted"\n'
            + "".join(tables)
        )
        assert run(["generate", "-q", "--no-cache"]) == 0
        assert run(["check", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        package = import_module("ros_adapted")
        for name in ("rtc", "nav_msgs.msg", "geometry_msgs.msg", "sensor_msgs.msg"):
            import_module(f"ros_adapted.{name}")
        for number in range(len(PAIRS)):
            import_module(f"ros_adapted.adapters.to{number}")
            import_module(f"ros_adapted.adapters.from{number}")
        return package


def converted(package: ModuleType, name: str, sample: Any) -> Any:
    """Return the output of an adapter for a sample, one second after the system's start."""
    module = import_module(f"ros_adapted.adapters.{name.lower()}")
    system, out, back = connected(getattr(module, name)("X0"))
    system.activate("X0")
    system.run(1_000_000_000)
    out.write(sample)
    system.run(2_000_000_000)
    return back.read()


def number_of(ros: str) -> int:
    return next(n for n, pair in enumerate(PAIRS) if pair.ros.endswith(f"::{ros}"))


def test_pose(adapters: ModuleType) -> None:
    rtc = adapters.rtc
    pose = rtc.Pose2D(rtc.Point2D(1.0, -2.0), math.pi / 2)
    sample = rtc.TimedPose2D(rtc.Time(5, 6), pose)
    for ros in ("PoseStamped", "Odometry"):
        number = number_of(ros)
        made = converted(adapters, f"To{number}", sample)
        inner = made.pose if ros == "PoseStamped" else made.pose.pose
        assert (made.header.stamp.sec, made.header.stamp.nanosec) == (5, 6)
        assert (inner.position.x, inner.position.y) == (1.0, -2.0)
        assert inner.orientation.z == pytest.approx(math.sqrt(0.5))
        assert inner.orientation.w == pytest.approx(math.sqrt(0.5))
        back = converted(adapters, f"From{number}", made)
        assert back.tm == sample.tm
        assert back.data.position == pose.position
        assert back.data.heading == pytest.approx(pose.heading)
        if ros == "Odometry":
            assert made.header.frame_id == "odom"
            assert made.child_frame_id == 'base "link"'
            assert list(made.pose.covariance) == [0.25] * 36
            assert made.twist.twist.linear.z == 1.0


def test_an_adapter_converts_in_the_tick_of_its_source(adapters: ModuleType) -> None:
    """The sample is there when `write` returns, in simulated and in real time."""
    rtc = adapters.rtc
    module = import_module(f"ros_adapted.adapters.to{number_of('TwistStamped')}")
    adapter = getattr(module, f"To{number_of('TwistStamped')}")("X0")
    system, out, back = connected(adapter)
    out.write(rtc.TimedVelocity2D(rtc.Time(1, 0), rtc.Velocity2D(0.5, 0.0, 0.0)))
    assert not back.is_new()  # It is not ACTIVE yet.
    system.activate("X0")
    system.run(1)
    assert back.read().twist.linear.x == 0.5
    for vx in (1.5, 2.5):
        sample = rtc.TimedVelocity2D(rtc.Time(2, 0), rtc.Velocity2D(vx, 0.0, 0.0))
        out.write(sample)
        assert back.read().twist.linear.x == vx
    system.deactivate("X0")
    system.run(20_000_000)
    out.write(sample)
    assert not back.is_new()


def test_a_sample_that_cannot_be_converted(adapters: ModuleType) -> None:
    """The adapter goes to ERROR, and not its source; samples wait until it is reset."""
    rtc = adapters.rtc
    name = f"To{number_of('OccupancyGrid')}"
    module = import_module(f"ros_adapted.adapters.{name.lower()}")
    system, out, back = connected(getattr(module, name)("X0"))
    failures: list[str] = []
    system.on_failure = lambda failure: failures.append(str(failure))
    system.activate("X0")
    system.activate("Peer0")
    system.run(1)
    grid = rtc.OccupancyGridMap()
    grid.config.xScale = 0.5
    assert out.write(grid) is PortStatus.PORT_OK
    grid.config.yScale = 0.5
    assert out.write(grid) is PortStatus.PORT_OK
    system.run(20_000_000)
    assert system.state("X0") is ERROR_STATE
    assert system.state("Peer0") is ACTIVE_STATE
    assert ["not square" in failure for failure in failures] == [True]
    assert not back.is_new()
    system.reset("X0")
    system.run(40_000_000)
    system.activate("X0")
    system.run(60_000_000)
    assert back.read().info.resolution == 0.5


class _Fetched(DataConnector[Any]):
    is_fetched = True


def test_fetched_samples_are_converted_in_one_tick(adapters: ModuleType) -> None:
    """A port that fetches its samples, as in OpenRTM, has none waiting after a tick."""
    rtc = adapters.rtc
    number = number_of("TwistStamped")
    module = import_module(f"ros_adapted.adapters.to{number}")
    adapter = getattr(module, f"To{number}")("X0")
    system, _, back = connected(adapter)
    port = adapter.in_ports["input"]
    far: OutPort[Any] = OutPort("far", port.type)
    connector = _Fetched("c", far, port, {}, system.clock.guard)
    connector.attach()
    speeds = [0.5, 1.5, 2.5]
    waiting = [
        rtc.TimedVelocity2D(rtc.Time(1, 0), rtc.Velocity2D(vx, 0.0, 0.0))
        for vx in speeds
    ]

    def feed() -> None:
        if waiting and system.state("X0") is ACTIVE_STATE:
            connector.give(waiting.pop(0))

    port._feed = feed
    system.activate("X0")
    system.run(1)
    found = []
    while back.is_new():
        found.append(back.read().twist.linear.x)
    assert found == speeds


def test_a_ring_of_adapters_turns_with_their_ticks(adapters: ModuleType) -> None:
    rtc = adapters.rtc
    number = number_of("TwistStamped")
    there, back = (
        getattr(import_module(f"ros_adapted.adapters.{kind.lower()}{number}"), name)(
            kind
        )
        for kind in ("To", "From")
        for name in (f"{kind}{number}",)
    )
    system = System(SimulatedClock())
    for adapter in (there, back):
        system.add(adapter)
        system.activate(adapter.instance_name)
    system.connect(("To", "output"), ("From", "input"))
    system.connect(("From", "output"), ("To", "input"))
    system.run(1)
    outside: OutPort[Any] = OutPort("out", rtc.TimedVelocity2D)
    DataConnector(
        "c", outside, there.in_ports["input"], {}, system.clock.guard
    ).attach()
    outside.write(rtc.TimedVelocity2D())
    system.run(100_000_000)
    assert there.in_ports["input"].is_new()


def test_velocity(adapters: ModuleType) -> None:
    rtc = adapters.rtc
    velocity = rtc.Velocity2D(0.5, -0.25, 1.5)
    sample = rtc.TimedVelocity2D(rtc.Time(5, 6), velocity)
    stamped = converted(adapters, f"To{number_of('TwistStamped')}", sample)
    assert (stamped.twist.linear.x, stamped.twist.linear.y) == (0.5, -0.25)
    assert stamped.twist.angular.z == 1.5
    assert converted(adapters, f"From{number_of('TwistStamped')}", stamped) == sample
    twist = converted(adapters, f"To{number_of('Twist')}", sample)
    back = converted(adapters, f"From{number_of('Twist')}", twist)
    assert back.data == velocity
    # A Twist has no time stamp: the result has the time of the conversion.
    assert 1.0 <= back.tm.sec + back.tm.nsec / 1e9 <= 2.0


def test_ranges(adapters: ModuleType) -> None:
    rtc = adapters.rtc
    config = rtc.RangerConfig(-1.5, 1.5, 0.25, 0.125, 8.0, 0.0, 4.0)
    sample = rtc.RangeData(rtc.Time(5, 6), [1.0, 2.5, 0.5], config=config)
    number = number_of("LaserScan")
    scan = converted(adapters, f"To{number}", sample)
    assert (scan.angle_min, scan.angle_max, scan.angle_increment) == (-1.5, 1.5, 0.25)
    assert (scan.range_min, scan.range_max, scan.scan_time) == (0.125, 8.0, 0.25)
    assert scan.time_increment == 0.5
    assert list(scan.ranges) == [1.0, 2.5, 0.5]
    assert converted(adapters, f"From{number}", scan) == sample


def test_angles(adapters: ModuleType) -> None:
    rtc = adapters.rtc
    sample = rtc.TimedDoubleSeq(rtc.Time(5, 6), [0.5, -0.5])
    number = number_of("JointState")
    joints = converted(adapters, f"To{number}", sample)
    assert list(joints.name) == ["left", "right"]
    assert list(joints.position) == [0.5, -0.5]
    assert converted(adapters, f"From{number}", joints) == sample


def test_map(adapters: ModuleType) -> None:
    """A tile has its position; cells above 100 are unknown."""
    rtc = adapters.rtc
    origin = rtc.Pose2D(rtc.Point2D(1.0, 2.0), math.pi / 2)
    sample = rtc.OccupancyGridMap(
        rtc.Time(5, 6),
        rtc.OGMapConfig(0.5, 0.5, 8, 4, origin),
        rtc.OGMapTile(2, 1, 3, 2, bytes((0, 50, 100, 101, 200, 255))),
    )
    number = number_of("OccupancyGrid")
    grid = converted(adapters, f"To{number}", sample)
    assert (grid.info.resolution, grid.info.width, grid.info.height) == (0.5, 3, 2)
    assert grid.info.origin.position.x == pytest.approx(0.5)
    assert grid.info.origin.position.y == pytest.approx(3.0)
    assert list(grid.data) == [0, 50, 100, -1, -1, -1]
    back = converted(adapters, f"From{number}", grid)
    assert back.tm == sample.tm
    assert (back.config.width, back.config.height, back.map.column) == (3, 2, 0)
    assert back.config.origin.heading == pytest.approx(math.pi / 2)
    assert back.map.cells == bytes((0, 50, 100, 255, 255, 255))
    assert converted(adapters, f"To{number}", back) == grid
    sample.config.yScale = 0.25
    with pytest.raises(ValueError, match=r"0.5 by 0.25 m are not square"):
        conversions.map_to_grid(sample, grid)


class _Quaternion:
    def __init__(self, x: float, y: float, z: float, w: float) -> None:
        self.x, self.y, self.z, self.w = x, y, z, w


@given(st.floats(-math.pi, math.pi), st.floats(0.1, 10.0))
def test_heading_of_a_rotation_about_z(heading: float, length: float) -> None:
    q = _Quaternion(
        0, 0, length * math.sin(heading / 2), length * math.cos(heading / 2)
    )
    difference = conversions.heading_of(q) - heading
    assert math.remainder(difference, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_times_outside_of_the_other_side() -> None:
    class Time:
        sec, nsec, nanosec = 4_000_000_000, 7, 0

    stamp = Time()
    conversions.time_to_stamp(Time(), stamp)
    assert (stamp.sec, stamp.nanosec) == (2**31 - 1, 7)
    stamp.sec, tm = -1, Time()
    conversions.time_of_stamp(stamp, tm)
    assert (tm.sec, tm.nsec) == (0, 0)


def test_pairs() -> None:
    assert pair_of("RTC::TimedPose2D", "nav_msgs::msg::Odometry") == (PAIRS[1], True)
    assert pair_of("nav_msgs::msg::Odometry", "IIS::TimedPose2D") == (PAIRS[1], False)
    assert pair_of("RTC::TimedPose2D", "geometry_msgs::msg::Twist") is None


OWN = """
#include "geometry_msgs/msg/Twist.idl"
module Lab {
    struct Time { unsigned long sec; unsigned long nsec; };
    struct Velocity { double vx; ///< Forward [mm/s].
        double vy; double va; };
    struct TimedVelocity2D { Time tm; Velocity data; };
    struct Metres { @unit("m") double x; };
    struct Turned { @unit("rad") double x; };
};
"""
TWIST = "geometry_msgs::msg::Twist"
WRONG = {
    table("A", "Lab::TimedVelocity2D", TWIST): (
        "ADP0005",
        "'data.vx' of Lab::TimedVelocity2D is in mm/s, not in m/s",
    ),
    table("A", "Lab::Turned", "Lab::Metres", 'map = { x = "x" }'): (
        "ADP0005",
        "'x' is in m, 'x' in rad",
    ),
    table("A", "Lab::Metres", "Lab::Metres", 'set = { x = "far" }'): (
        "ADP0004",
        "'x' is double, which is not 'far'",
    ),
    table("A", "Lab::Metres", "Lab::Metres", "set = { y = 1 }"): (
        "ADP0003",
        "Lab::Metres has no member 'y'",
    ),
    table("A", "Lab::Metres", "Lab::Metres", "set = { x = { y = 1 } }"): (
        "ADP0003",
        "'x' of Lab::Metres is not a struct",
    ),
    table("A", "Lab::Metres", "Lab::Metres", "set = { x = [[1]] }"): (
        "PRJ0003",
        "must be a table",
    ),
}


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("RTC::TimedPose2D", "ExtendedDataTypes.idl"),
        ("nav_msgs::msg::Odometry", "nav_msgs/msg/Odometry.idl"),
    ],
)
def test_a_struct_that_is_not_included(
    name: str,
    file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text("struct Own { long x; };\n")
    Path("rtgen.toml").write_text(
        f'[sources]\npaths = ["t.idl"]\n{table("A", "Own", name)}'
    )
    assert run(["generate", "--no-cache"]) == 2
    errors = capsys.readouterr().err
    assert f"error[ADP0002]: adapter 'A': no struct '{name}'" in errors
    assert f'hint: #include "{file}" in a definition' in errors


@pytest.mark.parametrize("text", WRONG)
def test_wrong_adapters(
    text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(OWN)
    Path("rtgen.toml").write_text(f'[sources]\npaths = ["t.idl"]\n{text}')
    assert run(["generate", "--no-cache"]) == 2
    code, message = WRONG[text]
    errors = capsys.readouterr().err
    assert f"rtgen.toml:3:2: error[{code}]" in errors
    assert message in errors
