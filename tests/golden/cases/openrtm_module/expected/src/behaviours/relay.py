# Created once by rtgen 0.2.0 from relay.idl.
# Yours to edit: rtgen never touches it again.
"""Relay: Passes on what it gets, while it is switched on."""

from __future__ import annotations

from robots import relays
from robots.components.relay import RelayBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class OwnServant(relays.Lever):
    """Executes the calls of the provider `own`."""

    def turn(self, on: bool) -> None:
        raise NotImplementedError


class Relay(RelayBase):
    """Passes on what it gets, while it is switched on."""

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when it is created."""
        self.own.set_servant(OwnServant())
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
