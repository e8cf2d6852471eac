"""MotorControl: wheel speeds for a base that another component simulates."""

from __future__ import annotations

from refnav.base_control import BaseControl, TravelSwitch
from refrobots import rtc
from refrobots.components.motor_control import MotorControlBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class MotorControl(MotorControlBase):
    """RefHardRh3 without the base."""

    def on_initialize(self) -> ReturnCode_t:
        """Offer the services."""
        switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(switch)
        self.BumpRefHard.set_servant(switch.bumper)
        self._control = BaseControl(self.InTargetVelocity, self.config, switch)
        self._speeds = rtc.TimedDoubleSeq(data=[0.0, 0.0])
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest."""
        self._control.start(self.now())
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._send((0.0, 0.0))
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._send((0.0, 0.0))
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the target speeds of the wheels, and pass on their angles."""
        self._send(self._control.wheel_speeds(self.now()))
        while self.InWheelAngle.is_new():
            if (angles := self.InWheelAngle.read()) is not None:
                self.OutWheelAngle.write(angles)
        return RTC_OK

    def _send(self, speeds: tuple[float, float]) -> None:
        self._speeds.data[:] = speeds
        self.stamp(self._speeds)
        self.WheelSpeed.write(self._speeds)
