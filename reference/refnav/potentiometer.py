"""Potentiometer: its voltage, constant or oscillating."""

from __future__ import annotations

from math import sin, tau

from refrobots import rtc
from refrobots.components.potentiometer import PotentiometerBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t


class Potentiometer(PotentiometerBase):
    """Oscillates from its activation on."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start in the middle."""
        self._begin = self.now()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the voltage."""
        config = self.config
        turned = sin(tau * config.frequency * (self.now() - self._begin) / SECOND)
        sample = rtc.TimedDouble(data=config.offset + config.amplitude * turned)
        self.stamp(sample)
        self.voltage.write(sample)
        return RTC_OK
