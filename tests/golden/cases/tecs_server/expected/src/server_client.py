# Created once by rtgen 0.2.0 from cdl/server.cdl.
# Yours to edit: rtgen never touches it again.
"""ServerClient: Calls sServer of a TECS board"""

from __future__ import annotations

from robots.tecs.server.server_marshaller import ServerClientBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class ServerClient(ServerClientBase):
    """Calls sServer of a TECS board."""

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
