"""The position of RH2: corrected odometry, and the localisation that corrects it."""

from __future__ import annotations

from math import pi

import pytest
from component_bench import Bench

from refnav.localize_center import ANNOUNCEMENTS, LocalizeCenter
from refnav.odometry_rh2 import OdometryRh2
from refnav.ref_hard_rh2 import RefHardRh2
from refrobots import iis, rtc


def pose(x: float, y: float, theta: float, sec: int = 0) -> iis.TimedPose2D:
    data = rtc.Pose2D(rtc.Point2D(x, y), theta)
    return iis.TimedPose2D(rtc.Time(sec, 0), [], data, [])


def angles(sec: int, left: float, right: float) -> rtc.TimedDoubleSeq:
    return rtc.TimedDoubleSeq(rtc.Time(sec, 0), [left, right])


def plain(samples: list[iis.TimedPose2D]) -> list[tuple[float, float, float]]:
    return [(s.data.position.x, s.data.position.y, s.data.heading) for s in samples]


def test_odometry_counts_on_from_the_pose_that_it_is_told() -> None:
    bench = Bench(OdometryRh2("OdometryRh20"), 100.0)
    bench.activate()
    bench.send("CurrentWheelAngle", angles(1, 0.0, 0.0))
    bench.run(0.01)
    bench.send("CurrentWheelAngle", angles(2, 10.0, 10.0))
    bench.run(0.01)
    # The initial position is not measured.
    assert bench.sent("OdometryPosition") == []
    bench.send("LocalizedPosition", pose(5.0, 6.0, pi / 2))
    bench.send("CurrentWheelAngle", angles(3, 20.0, 20.0))
    bench.run(0.01)
    assert plain(bench.sent("OdometryPosition")) == [
        pytest.approx((5.0, 7.0, pi / 2)),
    ]


@pytest.fixture
def bench() -> Bench:
    bench = Bench(LocalizeCenter("LocalizeCenter0"), 100.0)
    bench.set(startX="1.0", startY="2.0", startTheta="0.5")
    bench.activate()
    return bench


def start(bench: Bench) -> None:
    bench.run(ANNOUNCEMENTS * 0.01)
    bench.sent("dp_out0")


def test_the_start_pose_is_sent_twenty_times(bench: Bench) -> None:
    bench.send("dp_odmIn", pose(9.0, 9.0, 0.0))
    bench.run(1.0)
    assert plain(bench.sent("dp_out0")) == [(1.0, 2.0, 0.5)] * 20


def test_a_restart_does_not_bring_odometry_back_to_the_start(bench: Bench) -> None:
    start(bench)
    bench.deactivate()
    bench.send("dp_odmIn", pose(3.0, 4.0, 0.1))
    bench.activate()
    bench.run(0.405)
    assert set(plain(bench.sent("dp_out0"))) == {(3.0, 4.0, 0.1)}


def test_with_a_silent_odometry_a_restart_sends_the_start_pose(bench: Bench) -> None:
    start(bench)
    bench.deactivate()
    bench.activate()
    bench.run(0.405)
    assert plain(bench.sent("dp_out0")) == [(1.0, 2.0, 0.5)] * 20


def test_what_it_goes_on_without_is_reported(bench: Bench) -> None:
    for _ in range(26):
        bench.send("dp_odmIn", pose(3.0, 4.0, 0.1))
        bench.run(0.2)
    statistics = bench.system.statistics("LocalizeCenter0")
    assert statistics.condition == "dp_ceilIn: nothing newer than 5 s"
    bench.sent("dp_out0")
    bench.run(0.7)
    # The ceiling is not compared with poses of that age.
    bench.send("dp_ceilIn", pose(5.0, 4.0, 0.1))
    bench.run(0.1)
    assert set(plain(bench.sent("dp_out0"))) == {(3.0, 4.0, 0.1)}
    statistics = bench.system.statistics("LocalizeCenter0")
    assert statistics.condition == "dp_odmIn: nothing newer than 0.5 s"


def test_odometry_is_repeated_every_cycle(bench: Bench) -> None:
    start(bench)
    bench.send("dp_odmIn", pose(3.0, 4.0, 0.1))
    bench.run(0.405)
    assert plain(bench.sent("dp_out0")) == [(3.0, 4.0, 0.1)] * 2


def test_the_mean_is_weighted_nineteen_to_one(bench: Bench) -> None:
    start(bench)
    bench.send("dp_odmIn", pose(3.0, 4.0, 3.1, sec=7))
    bench.send("dp_ceilIn", pose(5.0, 2.0, -3.1, sec=7))
    bench.run(0.01)
    turn = (2 * pi - 6.2) / 20
    [mean] = plain(bench.sent("dp_out0"))
    assert mean == pytest.approx((3.1, 3.9, 3.1 + turn))


def test_a_late_picture_corrects_by_what_was_wrong_then(bench: Bench) -> None:
    start(bench)
    bench.send("dp_odmIn", pose(0.0, 0.0, 0.0, sec=1), pose(1.0, 0.0, 0.0, sec=2))
    bench.send("dp_ceilIn", pose(0.0, 2.0, 0.0, sec=1))
    bench.run(0.01)
    # A second picture of the same time finds a twentieth of the error corrected.
    bench.send("dp_ceilIn", pose(0.0, 2.0, 0.0, sec=1))
    bench.run(0.01)
    first, second = plain(bench.sent("dp_out0"))
    assert first == pytest.approx((1.0, 0.1, 0.0))
    assert second == pytest.approx((1.0, 0.195, 0.0))


def test_the_base_tells_simulated_sensors_where_it_is() -> None:
    bench = Bench(RefHardRh2("RefHardRh20"), 1000.0)
    bench.set(PlantStart_x="1.0", PlantStart_theta="0.5", CommandTimeout="0.0")
    bench.activate()
    velocity = rtc.Velocity2D(0.3, 0.0, 0.0)
    bench.send("InTargetVelocity", iis.TimedVelocity2D(data=velocity))
    bench.run(1.0)
    poses = bench.sent("PlantPose")
    assert plain(poses)[0] == (1.0, 0.0, 0.5)
    assert plain(poses)[-1] == tuple(bench.component.observables["truth"]())
    assert plain(poses)[-1][0] > 1.2
    assert poses[-1].tm == rtc.Time(1, 0)
