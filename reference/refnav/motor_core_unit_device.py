"""MotorCoreUnitDevice: simulation of a unit of gear, motor, driver and encoders."""

from __future__ import annotations

from math import tau
from typing import Final

from refnav.drive_402 import HomingDrive, wrapped
from refnav.drive_runner import SimulatedDrive
from refnav.motors import MOTOR_CORE_UNIT
from refrobots.components.motor_core_unit_device import MotorCoreUnitDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t

_TURN: Final = 1 << 17
"""Counts of the absolute encoder on the gear axis per turn."""


class MotorCoreUnitDevice(SimulatedDrive, MotorCoreUnitDeviceBase):
    """A simulated motor core unit that turns an arm.

    Its observables are `angle` [rad] and `speed` [rad/s] of the gear axis.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self.switch_on(lambda alarm: HomingDrive(self.objects, MOTOR_CORE_UNIT, alarm))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Execute the drive's control loop once."""
        code = super().on_execute(ec_id)
        objects = self.objects
        axis = self.axis
        turns = axis.angle / tau
        gear = objects.Motor_shaft_revolutions / objects.Driving_shaft_revolutions
        objects.Gear_encoder_angle = int(turns * _TURN // 1) % _TURN
        objects.Position_actual_internal_value = wrapped(
            turns * gear * objects.Encoder_increments // 1
        )
        objects.Motor_temperature = round(10.0 * axis.temperature)
        return code
