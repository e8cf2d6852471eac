# Created once by rtgen 0.2.0 from lamp.idl.
# Yours to edit: rtgen never touches it again.
"""The component lamp."""

from __future__ import annotations

from robots.components.lamp import lampBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class lamp(lampBase):
    """The component lamp."""

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when it is created."""
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
