"""The objects of CiA 402 that a simulated drive uses, and their units."""

from __future__ import annotations

from math import tau
from typing import Protocol


class DriveObjects(Protocol):
    """Objects common to the reference build's drives; units are the drive's own.

    Torques are in thousandths of the rated torque [mN m], currents of the rated current [mA].
    """

    Error_code: int
    Controlword: int
    Statusword: int
    Quick_stop_option_code: int
    Disable_operation_option_code: int
    Halt_option_code: int
    Fault_reaction_option_code: int
    Modes_of_operation: int
    Modes_of_operation_display: int
    Position_actual_value: int
    Following_error_window: int
    Following_error_time_out: int
    Position_window: int
    Position_window_time: int
    Velocity_demand_value: int
    Velocity_actual_value: int
    Velocity_window: int
    Velocity_window_time: int
    Target_torque: int
    Max_torque: int
    Max_current: int
    Torque_demand: int
    Motor_rated_current: int
    Motor_rated_torque: int
    Torque_actual_value: int
    Current_actual_value: int
    DC_link_circuit_voltage: int
    Target_position: int
    Min_position_limit: int
    Max_position_limit: int
    Polarity: int
    Max_profile_velocity: int
    Profile_velocity: int
    Profile_acceleration: int
    Profile_deceleration: int
    Quick_stop_deceleration: int
    Torque_slope: int
    Encoder_increments: int
    Motor_revolutions: int
    Motor_shaft_revolutions: int
    Driving_shaft_revolutions: int
    SI_unit_position: int
    SI_unit_velocity: int
    Following_error_actual_value: int
    Target_velocity: int
    Supported_drive_modes: int


class HomingObjects(DriveObjects, Protocol):
    """The objects of homing."""

    Home_offset: int
    Homing_method: int


class EposObjects(HomingObjects, Protocol):
    """The objects of EPOS's own modes: values in mA, increments and 0.001 rpm."""

    Current_setting_value: int
    Position_mode_setting_value: int
    Velocity_mode_setting_value: int


_RADIAN = 0x10
_DEGREE = 0x41
_REVOLUTION = 0xB4
_INCREMENT = 0xB5
_ANGLES = {_RADIAN: 1.0, _DEGREE: tau / 360.0, _REVOLUTION: tau}
_TIMES = {0x03: 1.0, 0x47: 60.0}


class Units:
    """Converts between a drive's units and its axis, by 608Fh, 6091h, 60A8h and 60A9h.

    Increments are counted at the motor, which is the axis then; degrees are those of the axis
    behind the gear. `position` [rad], `velocity` [rad/s] and `count` [rad], one step of the
    encoder. Raises ValueError for unknown units.
    """

    def __init__(self, objects: DriveObjects) -> None:
        increment = tau * objects.Motor_revolutions / objects.Encoder_increments
        prefix, what, _ = _parts(objects.SI_unit_position)
        gear = objects.Motor_shaft_revolutions / objects.Driving_shaft_revolutions
        if what == _INCREMENT:
            self.position = increment
            self.count = increment
        else:
            self.position = prefix * _known(_ANGLES, what)
            self.count = increment / gear
        prefix, what, per = _parts(objects.SI_unit_velocity)
        self.velocity = prefix * _known(_ANGLES, what) / _known(_TIMES, per)


def _parts(code: int) -> tuple[float, int, int]:
    """Return prefix, numerator and denominator of an SI unit."""
    exponent = code >> 24 & 0xFF
    prefix = 10.0 ** (exponent - 0x100 if exponent & 0x80 else exponent)
    return prefix, code >> 16 & 0xFF, code >> 8 & 0xFF


def _known(units: dict[int, float], code: int) -> float:
    try:
        return units[code]
    except KeyError:
        raise ValueError(f"no unit {code:02X}h is known") from None
