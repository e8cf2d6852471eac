# Created once by rtgen 0.2.0 from specs/sampler.eds.
# Yours to edit: rtgen never touches it again.
"""SamplerPiecesDevice: Device Sampler"""

from __future__ import annotations

from lab.components.sampler_pieces_device import SamplerPiecesDeviceBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class SamplerPiecesDevice(SamplerPiecesDeviceBase):
    """Device on a CANopen bus: Sampler.

    InPorts get the received data, data written to OutPorts are transmitted.
    """

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
