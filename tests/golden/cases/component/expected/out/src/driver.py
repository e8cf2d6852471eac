# Created once by rtgen 0.2.0 from robot.idl.
# Yours to edit: rtgen never touches it again.
"""Driver: Drives"""

from __future__ import annotations

from robots import drive
from robots.components.driver import DriverBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class SafetyServant(drive.Safety):
    """Executes the calls of the provider `safety`."""

    def Stop(self) -> None:
        raise NotImplementedError


class Driver(DriverBase):
    """Drives to the commanded position."""

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when it is created."""
        self.safety.set_servant(SafetyServant())
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Called when it is activated."""
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Called when it is deactivated."""
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Called in every cycle while it is active."""
        return RTC_OK
