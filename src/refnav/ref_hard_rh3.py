"""RefHardRh3: drives the wheels of the simulated base and reads their encoders."""

from __future__ import annotations

from math import tau

from refnav.base_control import BaseControl, TravelSwitch, true_wheels
from refnav.geometry import Pose
from refnav.plant import Plant, counted
from refrobots import rtc
from refrobots.components.ref_hard_rh3 import RefHardRh3Base
from rtgen.runtime import RTC_OK, ReturnCode_t


class RefHardRh3(RefHardRh3Base):
    """The simulated base.

    Its observables are `truth`, the true pose (x, y, theta) [m, rad], and `wheels`, the speeds of
    the left and the right wheel [rad/s].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Put the base on the floor and offer its services."""
        self._base = Plant(true_wheels(self.config))
        self._placed = False
        self._angles = rtc.TimedDoubleSeq(data=[0.0, 0.0])
        switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(switch)
        self.BumpRefHard.set_servant(switch)
        self._control = BaseControl(self.InTargetVelocity, self.config, switch)
        self.observables["truth"] = lambda: self._base.pose
        self.observables["wheels"] = lambda: tuple(self._base.speeds)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Switch the motors on, at rest; the base stays where it is."""
        config = self.config
        self._base.kinematics = true_wheels(config)
        if not self._placed:
            start = Pose(
                config.PlantStart_x, config.PlantStart_y, config.PlantStart_theta
            )
            self._base.place(start)
            self._placed = True
        self._now = self.now()
        self._control.start(self._now)
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake: without the component nothing drives the wheels."""
        self._base.halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._base.halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Drive the wheels on since the last execution, and send their angles."""
        config = self.config
        base = self._base
        now = self.now()
        dt = (now - self._now) * 1e-9
        self._now = now
        # The wheels first run on at the speeds they had: a command acts from now on.
        base.roll(dt)
        wanted = self._control.wheel_speeds(now)
        base.drive(wanted, config.Velocity_limit, config.Acceleration_limit * dt)
        count = tau / (config.EncoderCount * config.GearRatio)
        left, right = base.angles
        angles = self._angles
        angles.data[0] = counted(left, count) * config.EncoderConstant_L
        angles.data[1] = counted(right, count) * config.EncoderConstant_R
        self.stamp(angles)
        self.OutWheelAngle.write(angles)
        return RTC_OK
