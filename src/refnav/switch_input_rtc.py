"""SwitchInputRTC: chooses between the velocity of a game pad and that of the navigation."""

from __future__ import annotations

from refrobots.components.switch_input_rtc import SwitchInputRTCBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

BY_HAND = SECOND // 2
"""So long after the last sample of the game pad the navigation has to wait [ns]."""


class SwitchInputRTC(SwitchInputRTCBase):
    """The hand goes first."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """No hand was there yet."""
        self._touched: int | None = None
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Pass on what may be passed on."""
        now = self.now()
        by_hand = self.inVelJoy.read_newest()
        by_itself = self.inVelAuto.read_newest()
        if by_hand is not None:
            self._touched = now
            self.outVel.write(by_hand)
        elif by_itself is not None and (
            self._touched is None or now - self._touched > BY_HAND
        ):
            self.outVel.write(by_itself)
        return RTC_OK
