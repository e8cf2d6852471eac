"""Safety functions: Stop and Go, collision detection, and contacts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from component_bench import Bench

from refnav.base_control import TravelSwitch
from refnav.collision_detection import CollisionDetection
from refnav.motor_control import MotorControl
from refnav.ref_hard_four_x import RefHardFourX
from refnav.ref_hard_rh2 import RefHardRh2
from refnav.ref_hard_rh3 import RefHardRh3
from refnav.ref_hard_rh3_canopen import RefHardRh3Canopen
from refnav.ref_hard_rh3_tecs import RefHardRh3Tecs
from refnav.ref_hw import RefHw
from refrobots import RefHard, iis, rtc
from rtgen.runtime import SECOND, Component, LifeCycleState, SimulatedClock, System


def velocity(vx: float, va: float = 0.0) -> iis.TimedVelocity2D:
    return iis.TimedVelocity2D(data=rtc.Velocity2D(vx, 0.0, va))


def points(*places: tuple[float, float]) -> iis.TimedPoint2DSeq:
    return iis.TimedPoint2DSeq(data=[rtc.Point2D(x, y) for x, y in places])


class Console(Component):
    """Presses the buttons of a user interface."""

    def __init__(self) -> None:
        super().__init__("Console0")
        self.panel = self.add_consumer("panel", "RefHard", RefHard)


class Guarded:
    """A base with motor control, collision detection and an operator."""

    def __init__(self) -> None:
        self.motors = Bench(MotorControl("MotorControl0"), 100.0)
        self.system = self.motors.system
        self.detection = CollisionDetection("CollisionDetection0")
        self.console = Console()
        for component in (self.detection, self.console):
            self.system.add(component, 100.0)
        self.system.connect(
            ("Console0", "panel"), ("MotorControl0", "InventGUIRefHard")
        )
        self.link()
        source = self.system.component("Peer0")
        source.add_out_port("obstacles", iis.TimedPoint2DSeq)
        source.add_out_port("velocity", iis.TimedVelocity2D)
        for name in ("obstacles", "velocity"):
            self.system.connect(("Peer0", name), ("CollisionDetection0", name))
        self.motors.activate()
        self.system.activate("CollisionDetection0")
        self.motors.run(0.02)

    def link(self) -> None:
        """Let collision detection stop the base."""
        self.system.connect(
            ("CollisionDetection0", "BumpRefHard"),
            ("MotorControl0", "BumpRefHard"),
            name="bumper",
        )

    def wheels(self, vx: float = 0.3, *, scan: bool = True) -> float:
        """Return the speed of the wheels when the base is commanded a velocity for 0.1 s."""
        for _ in range(2):
            if scan:
                self.motors.send("obstacles", points())
            for name in ("velocity", "InTargetVelocity"):
                self.motors.send(name, velocity(vx))
            self.motors.run(0.05)
        speed = self.motors.sent("WheelSpeed")[-1].data[0]
        assert isinstance(speed, float)
        return speed

    @property
    def condition(self) -> str:
        return self.system.statistics("CollisionDetection0").condition


def test_a_base_whose_scanner_is_dead_is_stopped_under_the_hand() -> None:
    guarded = Guarded()
    assert guarded.wheels() > 0.0
    for _ in range(6):
        last = guarded.wheels(scan=False)
    assert last == 0.0
    assert guarded.condition == "obstacles: nothing newer than 0.5 s"
    # Neither a Go by hand nor the way back helps: there are no scans.
    guarded.console.panel.object.Go()
    assert guarded.wheels(scan=False) == 0.0
    assert guarded.wheels(-0.2, scan=False) == 0.0
    assert guarded.wheels() > 0.0
    assert guarded.condition == ""


def test_before_the_first_scan_the_base_is_held() -> None:
    guarded = Guarded()
    assert guarded.wheels(scan=False) == 0.0
    assert guarded.wheels() > 0.0


def test_a_base_whose_velocity_is_not_known_is_held() -> None:
    guarded = Guarded()
    assert guarded.wheels() > 0.0
    for _ in range(12):
        guarded.motors.send("obstacles", points())
        guarded.motors.send("InTargetVelocity", velocity(0.3))
        guarded.motors.run(0.05)
    assert guarded.motors.sent("WheelSpeed")[-1].data[0] == 0.0
    assert guarded.condition == "velocity: nothing newer than 0.5 s"


def test_points_come_nearer_between_two_scans() -> None:
    guarded = Guarded()
    wall = points((1.2, 0.0))
    guarded.motors.send("obstacles", wall)
    driven = 0.0
    for _ in range(40):
        for name in ("velocity", "InTargetVelocity"):
            guarded.motors.send(name, velocity(1.0))
        guarded.motors.run(0.01)
        driven += 0.01 * 0.1 * guarded.motors.sent("WheelSpeed")[-1].data[0]
    # At 1 m/s 0.5 m are needed to stop, from 0.65 m before the body.
    assert 0.1 < driven < 0.2


def test_the_end_of_collision_detection_does_not_release_the_base() -> None:
    guarded = Guarded()
    guarded.motors.send("obstacles", points((0.6, 0.0)))
    guarded.motors.send("velocity", velocity(0.3))
    guarded.motors.run(0.02)
    assert guarded.detection.observables["stopped"]() == (1.0,)
    guarded.system.deactivate("CollisionDetection0")
    assert guarded.wheels(scan=False) == 0.0
    # Active again, it releases the base that it stopped, once the way is free.
    guarded.system.activate("CollisionDetection0")
    guarded.motors.run(0.02)
    assert guarded.wheels() > 0.0


def test_a_fault_of_collision_detection_stops_the_base() -> None:
    guarded = Guarded()
    assert guarded.wheels() > 0.0
    context = guarded.system.context("CollisionDetection0")
    context.fail_component(guarded.detection, "broken")
    assert guarded.wheels(scan=False) == 0.0


def test_a_stop_that_does_not_arrive_is_tried_again() -> None:
    guarded = Guarded()
    assert guarded.wheels() > 0.0
    guarded.system.disconnect("bumper")
    guarded.motors.send("obstacles", points((0.6, 0.0)))
    guarded.motors.run(0.02)
    assert guarded.condition.startswith("BumpRefHard: ")
    assert guarded.system.state("CollisionDetection0") is LifeCycleState.ACTIVE_STATE
    guarded.link()
    assert guarded.wheels(scan=False) == 0.0
    assert guarded.detection.observables["stopped"]() == (1.0,)


def test_a_stopped_base_is_released_when_it_is_to_back_off() -> None:
    guarded = Guarded()

    def wheels(vx: float) -> float:
        guarded.motors.send("obstacles", points((0.6, 0.0)))
        return guarded.wheels(vx, scan=False)

    assert wheels(0.3) == 0.0
    assert guarded.detection.observables["stopped"]() == (1.0,)
    assert wheels(-0.2) == pytest.approx(-2.0)
    assert guarded.detection.observables["stopped"]() == (0.0,)


def test_go_of_the_bumper_takes_back_its_own_stop_alone() -> None:
    switch = TravelSwitch()
    switch.bumper.Stop()
    switch.Stop()
    switch.bumper.Go()
    assert switch.stopped
    switch.Go()
    assert not switch.stopped
    switch.bumper.Stop()
    assert switch.stopped
    switch.bumper.Go()
    assert not switch.stopped
    switch.bumper.Stop()
    switch.Go()
    assert not switch.stopped


def test_a_go_by_hand_before_an_obstacle_holds_until_the_next_scan() -> None:
    guarded = Guarded()
    panel = guarded.console.panel.object
    guarded.motors.send("obstacles", points((0.6, 0.0)))
    assert guarded.wheels(scan=False) == 0.0
    panel.Go()
    assert guarded.wheels(scan=False) > 0.0
    guarded.motors.send("obstacles", points((0.6, 0.0)))
    assert guarded.wheels(scan=False) == 0.0
    # Also stopped by hand: a free way is not enough.
    panel.Stop()
    assert guarded.wheels() == 0.0
    assert guarded.detection.observables["stopped"]() == (0.0,)
    panel.Go()
    assert guarded.wheels() > 0.0


@pytest.mark.parametrize(
    "base",
    [
        RefHw,
        RefHardRh2,
        RefHardRh3,
    ],
)
def test_a_contact_stops_the_base_and_is_reported(
    base: type[RefHw | RefHardRh2 | RefHardRh3], tmp_path: Path
) -> None:
    (tmp_path / "wall").write_text("w 1 -2 1 2\nc 0 3 0.5\n")
    bench = Bench(base("Base0"), 1000.0)
    bench.component.folder = tmp_path
    bench.set(PlantRoom="wall", CommandTimeout="0")
    bench.activate()

    def drive(speed: float) -> None:
        if base is RefHw:
            bench.send("WheelSpeed", rtc.TimedDoubleSeq(data=[speed, speed]))
        else:
            bench.send("InTargetVelocity", velocity(0.1 * speed))
        bench.run(3.0)

    drive(3.0)
    x, y, _ = bench.component.observables["truth"]()
    assert (x, y) == (pytest.approx(0.55, abs=1e-3), 0.0)
    assert bench.component.observables["wheels"]() == (0.0, 0.0)
    assert bench.state is LifeCycleState.ERROR_STATE
    assert bench.component.reason == "contact with an obstacle at (0.550, 0.000)"
    # It can back off, but not go on.
    bench.system.reset("Base0")
    bench.run(0.01)
    bench.activate()
    drive(-3.0)
    assert bench.state is LifeCycleState.ACTIVE_STATE
    assert bench.component.observables["truth"]()[0] < 0.0


def test_a_room_that_is_none(tmp_path: Path) -> None:
    bench = Bench(RefHw("RefHw0"), 1000.0)
    bench.component.folder = tmp_path
    bench.set(PlantRoom="nowhere")
    bench.activate()
    assert bench.component.reason == "PlantRoom: nowhere: No such file or directory"


BUMPED = (
    *(MotorControl, RefHardRh2, RefHardRh3),
    *(RefHardRh3Canopen, RefHardFourX, RefHardRh3Tecs),
)


@pytest.mark.parametrize("base", BUMPED, ids=lambda base: base.__name__)
def test_no_go_of_a_bumper_releases_a_stop_by_hand(base: type[Component]) -> None:
    system = System(SimulatedClock())
    system.add(base("Base0"), 100.0)
    console = Console()
    bumper = console.add_consumer("bumper", "RefHard", RefHard)
    system.add(console, 100.0)
    system.connect(("Console0", "panel"), ("Base0", "InventGUIRefHard"))
    system.connect(("Console0", "bumper"), ("Base0", "BumpRefHard"))
    system.activate("Base0")
    system.run(SECOND // 10)
    component: Any = system.component("Base0")
    inside = component if hasattr(component, "_control") else component._base
    switch = inside._control._switch
    console.panel.object.Stop()
    bumper.object.Go()
    assert switch.stopped
    console.panel.object.Go()
    assert not switch.stopped
    bumper.object.Stop()
    assert switch.stopped
