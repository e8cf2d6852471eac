"""The simulated drives: modes of operation, limits of the source document's tables, faults."""

from __future__ import annotations

from math import pi, tau
from types import SimpleNamespace
from typing import Any

import pytest
from device_objects import objects

from refnav.axis import AMBIENT, Axis, approach, ramped
from refnav.cia402 import Control, Mode, PowerState, Status, state_of
from refnav.drive_402 import (
    FOLLOWING_ERROR,
    OVER_VOLTAGE,
    TOO_HOT,
    UNDER_VOLTAGE,
    Drive,
    EposDrive,
    HomingDrive,
)
from refnav.drive_objects import Units
from refnav.motors import BEEGO_WHEEL, FTMD_WHEEL, MOTOR_CORE_UNIT

DT = 0.001


class Bench:
    """A drive that is enabled in a mode."""

    def __init__(self, name: str, mode: int, **values: object) -> None:
        self.alarms: list[int] = []
        self.objects: Any = objects(name, **values)
        kinds: dict[str, Any] = {
            "epos_drive": (EposDrive, BEEGO_WHEEL),
            "ftmd": (Drive, FTMD_WHEEL),
            "motor_core_unit": (HomingDrive, MOTOR_CORE_UNIT),
        }
        kind, motor = kinds[name]
        self.drive: Drive = kind(self.objects, motor, self.alarms.append)
        self.objects.Modes_of_operation = int(mode)
        self.enable()

    def enable(self) -> None:
        for word in (0x00, 0x06, 0x0F):
            self.control(word)
        assert self.state is PowerState.OPERATION_ENABLED

    def control(self, word: int) -> None:
        self.objects.Controlword = int(word)
        self.drive.step(DT)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / DT)):
            self.drive.step(DT)

    @property
    def state(self) -> PowerState | None:
        return state_of(self.objects.Statusword)

    def shows(self, *bits: int) -> bool:
        return all(self.objects.Statusword & bit for bit in bits)


DRIVES = pytest.mark.parametrize("name", ["epos_drive", "ftmd", "motor_core_unit"])


@DRIVES
def test_velocity_mode(name: str) -> None:
    bench = Bench(name, Mode.PROFILE_VELOCITY)
    target = bench.objects.Max_profile_velocity // 4
    bench.objects.Target_velocity = target
    speeds = []
    for _ in range(500):
        bench.drive.step(DT)
        speeds.append(bench.objects.Velocity_actual_value)
    assert speeds == sorted(speeds)
    assert speeds[-1] == pytest.approx(target, rel=1e-4)
    assert bench.shows(Status.TARGET_REACHED)
    assert not bench.shows(Status.SPEED_ZERO)
    steps = [b - a for a, b in zip([0, *speeds], speeds, strict=False)]
    assert max(steps) <= bench.objects.Profile_acceleration * DT + 2
    bench.objects.Target_velocity = 0
    bench.run(0.5)
    assert bench.shows(Status.TARGET_REACHED, Status.SPEED_ZERO)
    assert bench.objects.Velocity_actual_value == 0


@DRIVES
def test_velocity_is_that_of_the_position(name: str) -> None:
    """The units of both are those of the SI unit objects."""
    bench = Bench(name, Mode.PROFILE_VELOCITY)
    bench.objects.Target_velocity = bench.objects.Max_profile_velocity // 8
    bench.run(1.0)
    before = bench.objects.Position_actual_value
    bench.run(1.0)
    moved = bench.objects.Position_actual_value - before
    units = Units(bench.objects)
    turned = moved * units.position
    assert turned == pytest.approx(
        bench.objects.Velocity_actual_value * units.velocity, rel=1e-3
    )


def test_units_of_the_devices() -> None:
    epos, motor = Units(objects("epos_drive")), Units(objects("motor_core_unit"))
    assert epos.position == epos.count == pytest.approx(tau / 2000)
    assert epos.velocity == pytest.approx(tau / 60 / 1000)
    assert motor.position == pytest.approx(pi / 180e3)
    assert motor.velocity == pytest.approx(pi / 180e3)
    assert motor.count == pytest.approx(tau / (4096 * 100))
    with pytest.raises(ValueError, match="no unit 07h is known"):
        Units(objects("ftmd", SI_unit_position=0x00070000))


@DRIVES
def test_position_mode(name: str) -> None:
    bench = Bench(name, Mode.PROFILE_POSITION)
    target = round(0.2 * tau / Units(bench.objects).position)
    bench.objects.Target_position = target
    assert not bench.shows(Status.SET_POINT_ACKNOWLEDGE)
    bench.control(0x0F | Control.NEW_SET_POINT)
    assert bench.shows(Status.SET_POINT_ACKNOWLEDGE)
    assert not bench.shows(Status.TARGET_REACHED)
    bench.control(0x0F)
    assert not bench.shows(Status.SET_POINT_ACKNOWLEDGE)
    places = []
    for _ in range(2000):
        bench.drive.step(DT)
        places.append(bench.objects.Position_actual_value)
    assert abs(places[-1] - target) <= 2
    assert max(places) <= target + 2
    assert bench.shows(Status.TARGET_REACHED)


def test_set_points_follow_each_other_or_take_over() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_POSITION)
    places: list[int] = []

    def ask(target: int, *bits: int) -> None:
        bench.objects.Target_position = target
        bench.control(0x0F | sum(bits) | Control.NEW_SET_POINT)
        bench.control(0x0F)

    def run(seconds: float) -> None:
        for _ in range(round(seconds / DT)):
            bench.drive.step(DT)
            places.append(bench.objects.Position_actual_value)

    ask(20_000)
    ask(-10_000)
    # One waits, so there is no room for another.
    assert bench.shows(Status.SET_POINT_ACKNOWLEDGE)
    run(2.0)
    assert max(places) == pytest.approx(20_000, abs=600)
    assert places[-1] == pytest.approx(-10_000, abs=2)
    places.clear()
    ask(20_000)
    run(0.05)
    ask(-10_000, Control.CHANGE_AT_ONCE)
    run(1.0)
    assert max(places) < 0
    assert places[-1] == pytest.approx(-10_000, abs=2)
    ask(5_000, Control.RELATIVE)
    run(1.0)
    assert places[-1] == pytest.approx(-5_000, abs=4)


def test_torque_mode() -> None:
    bench = Bench("ftmd", Mode.PROFILE_TORQUE, Torque_slope=2000)
    bench.objects.Target_torque = 500
    bench.run(0.1)
    assert bench.objects.Torque_demand == pytest.approx(200, abs=4)
    assert not bench.shows(Status.TARGET_REACHED)
    bench.run(0.16)
    assert bench.objects.Torque_demand == 500
    assert bench.objects.Torque_actual_value == 500
    assert bench.objects.Current_actual_value == 500
    assert bench.shows(Status.TARGET_REACHED)
    # The axis reaches its maximum speed, and does not exceed it.
    bench.run(2.0)
    most = bench.objects.Max_profile_velocity
    assert bench.objects.Velocity_actual_value == pytest.approx(most, rel=1e-6)
    assert bench.shows(Status.INTERNAL_LIMIT)
    assert bench.objects.Torque_actual_value < 500


def test_synchronous_position_follows_and_keeps_its_speed() -> None:
    bench = Bench("motor_core_unit", Mode.CYCLIC_SYNCHRONOUS_POSITION)
    for n in range(1, 500):
        bench.objects.Target_position = n * 20
        bench.drive.step(DT)
        assert bench.shows(Status.FOLLOWS)
        assert abs(bench.objects.Position_actual_value - n * 20) < 1000
    assert bench.objects.Position_actual_value == pytest.approx(499 * 20, abs=3)
    assert bench.objects.Velocity_actual_value == pytest.approx(20_000, rel=1e-3)
    # A jump is executed at the greatest velocity.
    bench.objects.Max_profile_velocity = 100_000
    bench.objects.Target_position += 20_000
    bench.run(0.1)
    assert bench.shows(Status.INTERNAL_LIMIT)
    assert bench.objects.Velocity_actual_value == pytest.approx(100_000, rel=0.01)
    bench.run(0.5)
    assert bench.objects.Position_actual_value == pytest.approx(29_980, abs=3)


def test_homing() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_VELOCITY, Home_offset=90_000)
    bench.objects.Target_velocity = 50_000
    bench.run(0.5)
    bench.objects.Modes_of_operation = int(Mode.HOMING)
    bench.run(0.2)
    assert bench.objects.Modes_of_operation_display == Mode.HOMING
    assert not bench.shows(Status.HOMING_ATTAINED)
    bench.control(0x0F | Control.HOMING_START)
    assert bench.shows(Status.HOMING_ATTAINED)
    assert bench.objects.Position_actual_value == pytest.approx(90_000, abs=1)
    bench.control(0x0F)
    bench.objects.Homing_method = 1
    bench.control(0x0F | Control.HOMING_START)
    assert bench.shows(Status.HOMING_ERROR)


def test_modes_of_epos() -> None:
    bench = Bench("epos_drive", Mode.EPOS_VELOCITY)
    bench.objects.Velocity_mode_setting_value = 600_000
    bench.run(0.2)
    assert bench.objects.Velocity_actual_value == 600_000
    bench.objects.Velocity_mode_setting_value = 0
    bench.run(0.2)
    bench.objects.Modes_of_operation = int(Mode.EPOS_POSITION)
    bench.objects.Position_mode_setting_value = 5000
    bench.run(0.5)
    assert bench.objects.Position_actual_value == pytest.approx(5000, abs=1)
    bench.objects.Modes_of_operation = int(Mode.EPOS_CURRENT)
    bench.objects.Current_setting_value = -1000
    bench.run(0.005)
    assert bench.objects.Current_actual_value == -200
    assert bench.objects.Velocity_actual_value < 0


def test_a_mode_that_the_drive_has_not_is_not_taken() -> None:
    bench = Bench("epos_drive", Mode.PROFILE_VELOCITY)
    bench.objects.Target_velocity = 600_000
    bench.run(0.1)
    bench.objects.Modes_of_operation = int(Mode.PROFILE_TORQUE)
    bench.run(0.1)
    assert bench.objects.Modes_of_operation_display == Mode.PROFILE_VELOCITY
    assert bench.objects.Velocity_actual_value == 600_000
    bench.objects.Modes_of_operation = int(Mode.NONE)
    bench.run(0.1)
    assert bench.objects.Velocity_actual_value == 0


def test_halt() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_POSITION)
    bench.objects.Target_position = 50_000
    bench.control(0x0F | Control.NEW_SET_POINT)
    bench.run(0.1)
    bench.control(0x0F | Control.HALT)
    bench.run(0.3)
    assert bench.shows(Status.TARGET_REACHED)
    held = bench.objects.Position_actual_value
    assert 0 < held < 30_000
    bench.control(0x0F)
    bench.run(1.0)
    assert bench.objects.Position_actual_value == pytest.approx(50_000, abs=2)


@pytest.mark.parametrize(("code", "most"), [(1, 0.35), (2, 0.15), (3, 0.08), (0, 2.0)])
def test_quick_stop_takes_as_long_as_its_deceleration(code: int, most: float) -> None:
    bench = Bench(
        "ftmd",
        Mode.PROFILE_VELOCITY,
        Quick_stop_option_code=code,
        Profile_deceleration=10_000_000,
        Quick_stop_deceleration=30_000_000,
    )
    bench.objects.Target_velocity = 3_000_000
    bench.run(0.5)
    bench.control(0x02)
    steps = 0
    while bench.objects.Velocity_actual_value > 10_000 and steps < 5000:
        bench.drive.step(DT)
        steps += 1
    if code == 0:
        # It coasts: only friction brakes, and the power is off at once.
        assert bench.state is PowerState.SWITCH_ON_DISABLED
        assert steps * DT > most
    else:
        assert most * 0.6 < steps * DT < most * 1.05 or code == 3
        assert steps * DT < most
        bench.run(0.01)
        assert bench.state is PowerState.SWITCH_ON_DISABLED


def test_limits_of_the_motor_core_unit() -> None:
    """Table 5: 30 N m at most, 60 rpm at 60 V."""
    bench = Bench(
        "motor_core_unit",
        Mode.PROFILE_VELOCITY,
        Profile_acceleration=1_000_000_000,
        Max_current=1429,
    )
    bench.objects.Target_velocity = 360_000
    bench.drive.step(DT)
    assert bench.objects.Torque_actual_value == pytest.approx(2000, abs=1)
    assert bench.objects.Current_actual_value == pytest.approx(1429, abs=1)
    assert bench.shows(Status.INTERNAL_LIMIT)
    bench.run(2.0)
    assert bench.objects.Velocity_actual_value == pytest.approx(144_000, rel=1e-6)
    bench.drive.axis.voltage = 60.0
    bench.run(2.0)
    assert bench.objects.Velocity_actual_value == pytest.approx(360_000, rel=1e-6)
    assert bench.objects.DC_link_circuit_voltage == 60_000


def test_torque_is_limited_by_torque_and_by_current() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_TORQUE, Torque_slope=10_000_000)
    bench.objects.Target_torque = 2000
    bench.objects.Max_torque = 800
    bench.drive.step(DT)
    assert bench.objects.Torque_actual_value == 800
    bench.objects.Max_current = 500  # 3.5 A
    bench.drive.step(DT)
    assert bench.objects.Torque_actual_value == 700


def test_a_motor_at_peak_current_gets_too_hot() -> None:
    """Table 6: 7 A continuously, 10 A for a limited time."""
    axis = Axis(MOTOR_CORE_UNIT, 24.0)
    axis.load = -21.0
    for _ in range(15_000):
        axis.turn(21.0, 0.02)
    assert axis.current == pytest.approx(7.0)
    assert AMBIENT < axis.temperature < 85.0
    bench = Bench("motor_core_unit", Mode.PROFILE_TORQUE)
    bench.drive.axis.load = -30.0
    bench.objects.Target_torque = 2000
    for _ in range(5):
        assert not bench.shows(Status.WARNING)
        bench.drive.run(8.0)
    bench.drive.run(9.0)
    bench.drive.run(9.0)
    assert bench.shows(Status.WARNING)
    for _ in range(4):
        bench.drive.run(9.0)
    assert bench.state is PowerState.FAULT
    assert bench.alarms == [bench.objects.Error_code] == [TOO_HOT]


@pytest.mark.parametrize(
    ("voltage", "code"), [(9.9, UNDER_VOLTAGE), (60.1, OVER_VOLTAGE)]
)
def test_supply(voltage: float, code: int) -> None:
    bench = Bench("ftmd", Mode.PROFILE_VELOCITY)
    bench.objects.Target_velocity = 1_000_000
    bench.run(0.2)
    bench.drive.axis.voltage = voltage
    bench.drive.step(DT)
    assert bench.state is PowerState.FAULT_REACTION_ACTIVE
    bench.run(0.1)
    assert bench.state is PowerState.FAULT
    assert bench.objects.Velocity_actual_value == 0
    for word in (0x00, 0x80):
        bench.control(word)
    assert bench.state is PowerState.FAULT
    bench.drive.axis.voltage = 24.0
    for word in (0x00, 0x80):
        bench.control(word)
    assert bench.state is PowerState.SWITCH_ON_DISABLED
    assert bench.alarms == [code, 0]
    assert bench.objects.Error_code == 0
    bench.enable()


def test_following_error() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_POSITION)
    bench.drive.axis.load = -40.0
    bench.objects.Target_position = 90_000
    bench.control(0x0F | Control.NEW_SET_POINT)
    shown = False
    for _ in range(1000):
        bench.drive.step(DT)
        shown = shown or bench.shows(Status.FOLLOWING_ERROR)
        if bench.state is PowerState.FAULT_REACTION_ACTIVE:
            break
    assert shown
    assert bench.alarms == [FOLLOWING_ERROR]


def test_polarity() -> None:
    bench = Bench("motor_core_unit", Mode.PROFILE_VELOCITY, Polarity=0xC0)
    bench.objects.Target_velocity = 50_000
    bench.run(0.5)
    assert bench.drive.axis.speed < 0
    assert bench.objects.Velocity_actual_value == 50_000
    assert bench.objects.Position_actual_value > 0


def test_position_limits_of_the_software() -> None:
    bench = Bench(
        "motor_core_unit",
        Mode.PROFILE_POSITION,
        Min_position_limit=-1000,
        Max_position_limit=3000,
    )
    bench.objects.Target_position = 90_000
    bench.control(0x0F | Control.NEW_SET_POINT)
    bench.run(1.0)
    assert bench.objects.Position_actual_value == pytest.approx(3000, abs=2)
    assert bench.shows(Status.INTERNAL_LIMIT)


def test_a_drive_that_nobody_commands_stops() -> None:
    bench = Bench("epos_drive", Mode.PROFILE_VELOCITY)
    bench.objects.Target_velocity = 1_000_000
    bench.run(0.2)
    bench.drive.leave()
    bench.drive.run(0.5)
    assert bench.state is PowerState.SWITCH_ON_DISABLED
    assert not bench.shows(Status.REMOTE)
    assert bench.objects.Velocity_actual_value == 0
    # The previous controlword does not start it again.
    bench.drive.remote = True
    bench.run(0.1)
    assert bench.state is PowerState.SWITCH_ON_DISABLED
    assert bench.shows(Status.REMOTE)
    bench.enable()


def test_controlwords_that_come_between_two_turns_all_count() -> None:
    bench = Bench("ftmd", Mode.PROFILE_VELOCITY)
    bench.drive.fail(0x5000)
    bench.run(0.01)
    for word in (0x00, 0x80, 0x06, 0x0F):
        bench.objects.Controlword = word
        bench.drive.take(word)
    bench.drive.step(DT)
    assert bench.state is PowerState.OPERATION_ENABLED
    assert bench.alarms == [0x5000, 0]


def test_a_drive_that_starts_anew() -> None:
    bench = Bench("ftmd", Mode.PROFILE_VELOCITY)
    bench.objects.Target_velocity = 1_000_000
    bench.run(0.2)
    bench.drive.fail(0x5000)
    bench.objects.Controlword = 0
    bench.drive.restart()
    assert bench.state is PowerState.SWITCH_ON_DISABLED
    assert bench.objects.Modes_of_operation_display == 0
    assert bench.objects.Velocity_actual_value == pytest.approx(1_000_000, rel=1e-3)
    assert bench.alarms == [0x5000, 0]


def test_a_long_pause_is_caught_up_with() -> None:
    one, other = (Bench("ftmd", Mode.PROFILE_VELOCITY) for _ in range(2))
    for bench in (one, other):
        bench.objects.Target_velocity = 360_000
        bench.run(0.2)
    one.drive.run(1.0)
    other.run(1.0)
    assert one.objects.Position_actual_value == pytest.approx(
        other.objects.Position_actual_value, abs=100
    )


def test_ways_to_a_speed_and_to_a_place() -> None:
    assert ramped(1.0, 2.0, 0.3, 0.1) == 1.3
    assert ramped(2.0, 1.0, 0.3, 0.1) == 1.9
    assert ramped(0.05, -1.0, 0.3, 0.1) == 0.0
    assert ramped(0.0, -1.0, 0.3, 0.1) == -0.3
    place, speed, passed = 0.0, 10.0, 0.0
    for _ in range(2000):
        speed = min(speed, approach(3.0 - place, 25.0, DT))
        place += speed * DT
        passed = max(passed, place)
    assert place == pytest.approx(3.0, abs=1e-6)
    assert passed <= 3.0 + 1e-9
    assert approach(-1.0, float("inf"), 0.5) == -2.0
    assert approach(1.0, 0.0, 0.5) == 0.0


def test_objects_are_those_of_the_file() -> None:
    made = objects("ftmd", Controlword=6)
    assert isinstance(made, SimpleNamespace)
    assert (made.Controlword, made.Max_torque) == (6, 1429)
