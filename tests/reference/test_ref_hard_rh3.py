"""RefHardRh3 alone: wheel limits, encoders, Stop and Go, loss of the command."""

from __future__ import annotations

from itertools import pairwise
from math import tau

import pytest
from component_bench import Bench

from refnav.ref_hard_rh3 import RefHardRh3
from refrobots import RefHard, iis, rtc
from rtgen.runtime import SECOND, Component, LifeCycleState

PER_TURN = 2000 * 74.91


def velocity(vx: float, va: float = 0.0) -> iis.TimedVelocity2D:
    return iis.TimedVelocity2D(data=rtc.Velocity2D(vx, 0.0, va))


@pytest.fixture
def bench() -> Bench:
    bench = Bench(RefHardRh3("RefHardRh30"), 1000.0)
    bench.set(CommandTimeout="0")
    bench.activate()
    return bench


def truth(bench: Bench) -> tuple[float, ...]:
    return tuple(bench.component.observables["truth"]())


def angles(bench: Bench) -> list[tuple[float, float]]:
    return [(s.data[0], s.data[1]) for s in bench.sent("OutWheelAngle")]


def test_the_plant_has_a_geometry_of_its_own(bench: Bench) -> None:
    bench.send("InTargetVelocity", velocity(0.1))
    bench.run(10.0)
    x, y, theta = truth(bench)
    assert x == pytest.approx(0.995, abs=0.002)
    assert (y, theta) == (0.0, 0.0)
    bench.send("InTargetVelocity", velocity(0.0, 0.1))
    bench.run(10.0)
    assert truth(bench)[2] == pytest.approx(0.995 * 0.441 / 0.464, abs=0.002)


def test_an_overrun_costs_time_and_moves_the_base_no_further(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.send("InTargetVelocity", velocity(0.1))
    bench.run(1.0)
    before = truth(bench)[0]
    bench.run(0.001)
    step = truth(bench)[0] - before
    now = bench.component.now
    monkeypatch.setattr(bench.component, "now", lambda: now() + 5 * SECOND)
    before = truth(bench)[0]
    bench.run(0.001)
    assert truth(bench)[0] - before == pytest.approx(step, rel=1e-6)


def test_angles_are_whole_counts_of_the_encoder(bench: Bench) -> None:
    bench.send("InTargetVelocity", velocity(0.1, 0.03))
    bench.run(1.0)
    for left, right in angles(bench):
        for angle in (left, right):
            counts = angle / tau * PER_TURN
            assert counts == pytest.approx(round(counts), abs=1e-6)


def test_encoder_constants_scale_what_is_measured(bench: Bench) -> None:
    bench.set(EncoderConstant_L="2.0", EncoderConstant_R="-1.0")
    bench.send("InTargetVelocity", velocity(0.1))
    bench.run(1.0)
    left, right = angles(bench)[-1]
    assert left == pytest.approx(2.0, abs=0.05)
    assert right == pytest.approx(-0.5 * left)


def test_wheels_keep_their_limits(bench: Bench) -> None:
    bench.send("InTargetVelocity", velocity(3.0, 1.0))
    bench.run(1.0)
    count = tau / PER_TURN
    speeds = [(b[0] - a[0]) * 1000 for a, b in pairwise(angles(bench))]
    assert max(speeds) <= 10.0 + count * 1000
    assert speeds[-1] == pytest.approx(10.0, abs=count * 1000)
    assert all(b - a <= 0.05 + 2 * count * 1000 for a, b in pairwise(speeds))


def test_the_base_rests_when_commands_fail_to_come(bench: Bench) -> None:
    bench.set(CommandTimeout="0.2")
    bench.send("InTargetVelocity", velocity(0.3))
    bench.run(0.15)
    running = truth(bench)[0]
    bench.run(0.15)
    rest = truth(bench)
    assert rest[0] > running
    bench.run(1.0)
    assert truth(bench) == rest


class Console(Component):
    """A consumer of the base's service."""

    def __init__(self) -> None:
        super().__init__("Console0")
        self.base = self.add_consumer("base", "RefHard", RefHard)


@pytest.mark.parametrize("port", ["InventGUIRefHard", "BumpRefHard"])
def test_stop_halts_and_go_releases(bench: Bench, port: str) -> None:
    console = Console()
    bench.system.add(console, 10.0)
    bench.system.connect(("Console0", "base"), ("RefHardRh30", port))
    bench.send("InTargetVelocity", velocity(0.3))
    bench.run(1.0)
    console.base.object.Stop()
    bench.run(0.2)
    halted = truth(bench)
    bench.run(1.0)
    assert truth(bench) == halted
    console.base.object.Go()
    bench.run(1.0)
    assert truth(bench)[0] - halted[0] > 0.25


def test_the_base_stands_at_its_start_only_once() -> None:
    bench = Bench(RefHardRh3("RefHardRh30"), 1000.0)
    bench.set(PlantStart_x="1.0", PlantStart_y="2.0", PlantStart_theta="0.5")
    bench.activate()
    assert truth(bench) == (1.0, 2.0, 0.5)
    bench.send("InTargetVelocity", velocity(0.3))
    bench.run(0.4)
    there = truth(bench)
    bench.deactivate()
    bench.run(1.0)
    bench.activate()
    assert bench.state is LifeCycleState.ACTIVE_STATE
    bench.run(1.0)
    assert truth(bench) == pytest.approx(there, abs=1e-3)
