"""SwitchInputRTC: chooses between the velocity of a game pad and that of the navigation."""

from __future__ import annotations

from refrobots.components.switch_input_rtc import SwitchInputRTCBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

MANUAL_HOLD = SECOND // 2
"""Time after the last sample of the game pad for which the navigation is blocked [ns]."""


class SwitchInputRTC(SwitchInputRTCBase):
    """The game pad has priority."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start without a sample of the game pad."""
        self._touched: int | None = None
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Pass the selected velocity on."""
        now = self.now()
        by_hand = self.inVelJoy.read_newest()
        by_itself = self.inVelAuto.read_newest()
        if by_hand is not None:
            self._touched = now
            self.outVel.write(by_hand)
        elif by_itself is not None and (
            self._touched is None or now - self._touched > MANUAL_HOLD
        ):
            self.outVel.write(by_itself)
        return RTC_OK
