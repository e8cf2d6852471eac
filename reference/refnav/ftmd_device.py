"""FtmdDevice: the drive of a wheel of FourX, simulated."""

from __future__ import annotations

from refnav.drive_402 import Drive
from refnav.drive_runner import SimulatedDrive
from refnav.motors import FTMD_WHEEL
from refrobots.components.ftmd_device import FtmdDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class FtmdDevice(SimulatedDrive, FtmdDeviceBase):
    """A simulated wheel of FourX with its FTMD 1 axis.

    Its observables are `angle` [rad] and `speed` [rad/s] of the wheel.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self.switch_on(lambda alarm: Drive(self.objects, FTMD_WHEEL, alarm))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Execute the drive's control loop once."""
        code = super().on_execute(ec_id)
        celsius = self.axis.temperature
        self.objects.Driver_temperature = round(10.0 * celsius)
        return code
