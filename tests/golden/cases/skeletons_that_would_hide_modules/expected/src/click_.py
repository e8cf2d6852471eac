# Created once by rtgen 0.2.0 from rover.idl.
# Yours to edit: rtgen never touches it again.
"""The component click."""

from __future__ import annotations

from rover.components.click import clickBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class click(clickBase):
    """The component click."""

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
