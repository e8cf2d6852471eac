"""RefHardRh3: drives the wheels of the simulated base and reads their encoders."""

from __future__ import annotations

from math import tau

from refnav.geometry import Pose
from refnav.plant import DifferentialDrive, counted
from refrobots import RefHard, rtc
from refrobots.components.ref_hard_rh3 import RefHardRh3Base
from rtgen.runtime import RTC_OK, ReturnCode_t


class TravelSwitch(RefHard):
    """Both service ports work on one switch: whoever says Go releases the base."""

    def __init__(self) -> None:
        self.stopped = False

    def Stop(self) -> None:
        """Stop the travelling base."""
        self.stopped = True

    def Go(self) -> None:
        """Let the stopped base travel."""
        self.stopped = False


class RefHardRh3(RefHardRh3Base):
    """The simulated base.

    Its observables are `truth`, the true pose (x, y, theta) [m, rad], and `wheels`, the speeds of
    the left and the right wheel [rad/s].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Put the base on the floor and offer its services."""
        self._base = DifferentialDrive()
        self._placed = False
        self._angles = rtc.TimedDoubleSeq(data=[0.0, 0.0])
        self._switch = TravelSwitch()
        self.InventGUIRefHard.set_servant(self._switch)
        self.BumpRefHard.set_servant(self._switch)
        self.observables["truth"] = lambda: self._base.pose
        self.observables["wheels"] = lambda: (self._base.left, self._base.right)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Switch the motors on, at rest; the base stays where it is."""
        config = self.config
        if not self._placed:
            start = Pose(
                config.PlantStart_x, config.PlantStart_y, config.PlantStart_theta
            )
            self._base.place(start)
            self._placed = True
        self._switch.Go()
        self._vx = 0.0
        self._va = 0.0
        self._now = self._heard = self.now()
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
        base.roll(
            dt,
            config.PlantWheelRadiusLeft,
            config.PlantWheelRadiusRight,
            config.PlantWheelTread,
        )
        port = self.InTargetVelocity
        if port.is_new() and (command := port.read_newest()) is not None:
            self._vx = command.data.vx
            self._va = command.data.va
            self._heard = now
        elif 0.0 < config.CommandTimeout * 1e9 < now - self._heard:
            self._vx = self._va = 0.0
        if self._switch.stopped:
            left = right = 0.0
        else:
            sideways = 0.5 * self._va * config.WheelTread
            left = (self._vx - sideways) / config.WheelRadiusLeft
            right = (self._vx + sideways) / config.WheelRadiusRight
        base.drive(left, right, config.Velocity_limit, config.Acceleration_limit * dt)
        count = tau / (config.EncoderCount * config.GearRatio)
        angles = self._angles
        angles.data[0] = counted(base.left_angle, count) * config.EncoderConstant_L
        angles.data[1] = counted(base.right_angle, count) * config.EncoderConstant_R
        self.stamp(angles)
        self.OutWheelAngle.write(angles)
        return RTC_OK
