"""MotorCoreUnitDevice: gear, motor, driver and encoders in one, simulated."""

from __future__ import annotations

from math import tau
from typing import Final

from refnav.drive_402 import HomingDrive, wrapped
from refnav.drive_runner import DriveRunner
from refnav.motors import MOTOR_CORE_UNIT
from refrobots.components.motor_core_unit_device import MotorCoreUnitDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t

_TURN: Final = 1 << 17
"""What the absolute encoder on the gear axis makes of a turn."""


class MotorCoreUnitDevice(MotorCoreUnitDeviceBase):
    """A motor core unit that turns an arm.

    Its observables are `angle` [rad] and `speed` [rad/s] of the gear axis.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self._runner = DriveRunner(
            self, lambda alarm: HomingDrive(self.objects, MOTOR_CORE_UNIT, alarm)
        )
        axis = self._runner.drive.axis
        self.observables["angle"] = lambda: (axis.angle,)
        self.observables["speed"] = lambda: (axis.speed,)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Obey from now on."""
        self._runner.start()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._runner.leave()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._runner.leave()
        return RTC_OK

    def on_error(self, ec_id: int) -> ReturnCode_t:
        """Brake on."""
        self._runner.run()
        return RTC_OK

    def on_reset(self, ec_id: int) -> ReturnCode_t:
        """Start the drive's program anew."""
        self._runner.restart()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """One turn of the drive's loop."""
        self._runner.run()
        objects = self.objects
        axis = self._runner.drive.axis
        turns = axis.angle / tau
        gear = objects.Motor_shaft_revolutions / objects.Driving_shaft_revolutions
        objects.Gear_encoder_angle = int(turns * _TURN // 1) % _TURN
        objects.Position_actual_internal_value = wrapped(
            turns * gear * objects.Encoder_increments // 1
        )
        objects.Motor_temperature = round(10.0 * axis.temperature)
        return RTC_OK
