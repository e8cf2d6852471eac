# Created once by rtgen 0.2.0 from RTC.xml.
# Yours to edit: rtgen never touches it again.
"""The component GateComponent."""

from __future__ import annotations

from robots import Gate
from robots.components.gate_component import GateComponentBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class GateServant(Gate):
    """Executes the calls of the provider `gate`."""


class GateComponent(GateComponentBase):
    """The component GateComponent."""

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when it is created."""
        self.gate.set_servant(GateServant())
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Called when it is activated."""
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Called when it is deactivated."""
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Called when samples have arrived while it is active."""
        return RTC_OK
