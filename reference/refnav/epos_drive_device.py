"""EposDriveDevice: the drive of a wheel of beego, simulated."""

from __future__ import annotations

from refnav.drive_402 import EposDrive
from refnav.drive_runner import SimulatedDrive
from refnav.motors import BEEGO_WHEEL
from refrobots.components.epos_drive_device import EposDriveDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class EposDriveDevice(SimulatedDrive, EposDriveDeviceBase):
    """A simulated wheel of beego with its drive.

    Its observables are `angle` [rad] and `speed` [rad/s] of the motor.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Switch the drive on."""
        self.switch_on(lambda alarm: EposDrive(self.objects, BEEGO_WHEEL, alarm))
        return RTC_OK
