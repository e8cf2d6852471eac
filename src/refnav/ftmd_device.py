"""FtmdDevice: the drive of a wheel of FourX, simulated."""

from __future__ import annotations

from refnav.drive_402 import Drive
from refnav.drive_runner import DriveRunner
from refnav.motors import FTMD_WHEEL
from refrobots.components.ftmd_device import FtmdDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class FtmdDevice(FtmdDeviceBase):
    """A wheel of FourX with its FTMD 1 axis.

    Its observables are `angle` [rad] and `speed` [rad/s] of the wheel.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self._runner = DriveRunner(
            self, lambda alarm: Drive(self.objects, FTMD_WHEEL, alarm)
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
        celsius = self._runner.drive.axis.temperature
        self.objects.Driver_temperature = round(10.0 * celsius)
        return RTC_OK
