"""A base on two drives, without a bus: its commands, and its reaction to the loss of a drive."""

from __future__ import annotations

from math import tau
from types import SimpleNamespace
from typing import Any

import pytest
from device_objects import objects

from refnav.base_control import TravelSwitch
from refnav.canopen_base import CanopenBase, WheelPorts
from refnav.cia402 import PowerState
from refnav.drive_402 import EposDrive
from refnav.geometry import Pose
from refnav.motors import BEEGO_WHEEL
from rtgen.runtime import SECOND

GEAR = 14.0
POSITION = tau / 2000 / GEAR
VELOCITY = tau / 60_000 / GEAR
STEP = SECOND // 100


class In:
    """An InPort filled by the test."""

    def __init__(self) -> None:
        self.sample: Any = None

    def is_new(self) -> bool:
        return self.sample is not None

    def read_newest(self) -> Any:
        sample, self.sample = self.sample, None
        return sample


class Out:
    """An OutPort that passes on the written samples."""

    def __init__(self, take: Any) -> None:
        self._take = take

    def write(self, sample: Any) -> None:
        self._take(sample)


class Side:
    """A drive, and the ports connected to it; a cut one neither receives nor sends."""

    def __init__(self, name: str) -> None:
        self.objects = objects("epos_drive")
        self.drive = EposDrive(self.objects, BEEGO_WHEEL)
        self.cut = False
        self.status, self.motion = In(), In()
        self.ports: Any = WheelPorts(
            name,
            self.status,  # type: ignore[arg-type]
            self.motion,  # type: ignore[arg-type]
            Out(self._control),  # type: ignore[arg-type]
            Out(self._target),  # type: ignore[arg-type]
            SimpleNamespace,
            SimpleNamespace,
        )

    def _control(self, sample: Any) -> None:
        if not self.cut:
            self.objects.Controlword = sample.Controlword
            self.objects.Modes_of_operation = sample.Modes_of_operation
            self.drive.take(sample.Controlword)

    def _target(self, sample: Any) -> None:
        if not self.cut:
            self.objects.Target_velocity = round(sample.Target_velocity / VELOCITY)

    def send_position(self) -> None:
        self.drive.run(0.01)
        if not self.cut:
            made = self.objects
            self.status.sample = SimpleNamespace(Statusword=made.Statusword)
            self.motion.sample = SimpleNamespace(
                Position_actual_value=made.Position_actual_value * POSITION,
                Velocity_actual_value=made.Velocity_actual_value * VELOCITY,
            )


class Speeds:
    """Stand-in for the control: wheel speeds set by the test."""

    def __init__(self) -> None:
        self.wanted = (0.0, 0.0)
        self.switch = TravelSwitch()

    def start(self, now: int) -> None:
        self.wanted = (0.0, 0.0)

    def wheel_speeds(self, now: int) -> tuple[float, float]:
        return self.wanted


class Bench:
    def __init__(self) -> None:
        self.left, self.right = Side("left"), Side("right")
        self.control = Speeds()
        self.parameters = SimpleNamespace(
            Velocity_limit=10.0,
            EncoderConstant_L=1.0,
            EncoderConstant_R=2.0,
            PlantWheelTread=0.4,
            PlantWheelRadiusLeft=0.1,
            PlantWheelRadiusRight=0.1,
            PlantStart_x=1.0,
            PlantStart_y=2.0,
            PlantStart_theta=0.0,
            DriveTimeout=0.05,
        )
        self.base = CanopenBase(
            [self.left.ports],
            [self.right.ports],
            self.parameters,
            self.control,  # type: ignore[arg-type]
        )
        self.now = 0
        self.angles: list[tuple[float, float] | None] = []
        self.base.start(0)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 100)):
            self.left.send_position()
            self.right.send_position()
            self.angles.append(self.base.step(self.now))
            self.now += STEP

    @property
    def speeds(self) -> tuple[float, float]:
        return (
            self.left.drive.axis.speed / GEAR,
            self.right.drive.axis.speed / GEAR,
        )


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.run(0.1)
    return bench


def test_it_enables_its_drives(bench: Bench) -> None:
    for side in (bench.left, bench.right):
        assert side.drive.machine.state is PowerState.OPERATION_ENABLED
        assert side.objects.Modes_of_operation_display == 3
    assert bench.angles[-1] == (0.0, 0.0)
    assert bench.base.plant.pose == Pose(1.0, 2.0, 0.0)


def test_wheels_turn_as_they_are_told(bench: Bench) -> None:
    bench.control.wanted = (2.0, 3.0)
    bench.run(1.0)
    assert bench.speeds == pytest.approx((2.0, 3.0), rel=1e-3)
    assert bench.base.wheels == pytest.approx((2.0, 3.0), rel=1e-3)
    angles = bench.angles[-1]
    assert angles is not None
    left, right = angles[0], angles[1] / 2.0
    assert left == pytest.approx(1.95, abs=0.1)
    plant = bench.base.plant
    assert tuple(plant.angles) == (left, right)
    assert plant.theta == pytest.approx((right - left) * 0.1 / 0.4)


def test_speeds_are_limited(bench: Bench) -> None:
    bench.control.wanted = (20.0, -20.0)
    bench.run(1.0)
    assert bench.speeds == pytest.approx((10.0, -10.0), rel=1e-3)


def test_a_drive_that_is_lost_stops_the_other(bench: Bench) -> None:
    bench.control.wanted = (3.0, 3.0)
    bench.run(1.0)
    bench.left.cut = True
    bench.left.drive.leave()
    bench.run(0.5)
    assert bench.speeds == pytest.approx((0.0, 0.0), abs=1e-3)
    assert bench.angles[-1] is None
    where = bench.base.plant.pose
    bench.left.cut = False
    bench.left.drive.remote = True
    bench.run(0.5)
    assert bench.speeds == pytest.approx((3.0, 3.0), rel=1e-3)
    # The angle by which the lost wheel has turned meanwhile counts.
    turned = bench.left.objects.Position_actual_value * POSITION
    assert bench.base.plant.angles[0] == pytest.approx(turned)
    assert bench.base.plant.pose.x > where.x


@pytest.mark.parametrize("start", [0.0, 123.0])
def test_a_drive_that_was_switched_off_counts_anew(bench: Bench, start: float) -> None:
    bench.control.wanted = (3.0, 3.0)
    bench.run(1.0)
    bench.left.cut = True
    bench.run(0.5)
    before = bench.base.plant.angles[0]
    bench.left.drive = EposDrive(bench.left.objects, BEEGO_WHEEL)
    bench.left.drive.axis.angle = start * GEAR
    bench.left.objects.Controlword = 0
    bench.left.cut = False
    bench.control.wanted = (0.0, 0.0)
    bench.run(0.2)
    assert bench.base.plant.angles[0] == before


def test_a_fault_in_the_midst_of_it_is_reported(bench: Bench) -> None:
    bench.control.wanted = (3.0, 3.0)
    bench.run(0.5)
    bench.right.drive.fail(0x5000)
    with pytest.raises(RuntimeError, match="the right drive has a fault"):
        bench.run(0.5)
    bench.base.stop()
    bench.left.drive.run(0.5)
    assert bench.speeds == pytest.approx((0.0, 0.0), abs=1e-3)
    assert bench.left.drive.machine.state is PowerState.SWITCH_ON_DISABLED
    # Once it is restarted, the fault is reset.
    bench.base.start(bench.now)
    bench.control.wanted = (1.0, 1.0)
    bench.run(0.5)
    assert bench.speeds == pytest.approx((1.0, 1.0), rel=1e-3)
