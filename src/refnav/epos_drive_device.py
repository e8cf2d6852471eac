"""EposDriveDevice: the drive of a wheel of beego, simulated."""

from __future__ import annotations

from refnav.drive_402 import EposDrive
from refnav.drive_runner import DriveRunner
from refnav.motors import BEEGO_WHEEL
from refrobots.components.epos_drive_device import EposDriveDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class EposDriveDevice(EposDriveDeviceBase):
    """A wheel of beego with its drive.

    Its observables are `angle` [rad] and `speed` [rad/s] of the motor.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self._runner = DriveRunner(
            self, lambda alarm: EposDrive(self.objects, BEEGO_WHEEL, alarm)
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
        return RTC_OK
