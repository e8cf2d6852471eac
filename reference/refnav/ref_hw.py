"""RefHw: the base of the simulator."""

from __future__ import annotations

from math import tau

from refnav.base_control import contact, furnish, start_of, true_wheels
from refnav.map_text import MapError
from refnav.messages import pose_message
from refnav.newest import Newest
from refnav.plant import Plant, counted
from refrobots import iis, rtc
from refrobots.components.ref_hw import RefHwBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t


class RefHw(RefHwBase):
    """Its observables are `truth`, the true pose (x, y, theta) [m, rad], and `wheels` [rad/s]."""

    def on_initialize(self) -> ReturnCode_t:
        """Place the base."""
        config = self.config
        self._plant = Plant(true_wheels(config))
        self._command = Newest[rtc.TimedDoubleSeq](
            self.WheelSpeed, lambda: config.CommandTimeout
        )
        self.observables["truth"] = lambda: self._plant.pose
        self.observables["wheels"] = lambda: tuple(self._plant.speeds)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest at the place of the base."""
        config = self.config
        self._plant.kinematics = true_wheels(config)
        try:
            furnish(self._plant, config, self.folder)
        except MapError as error:
            return self.fail(f"PlantRoom: {error}")
        self._plant.start(start_of(config))
        self._command.start(self.now())
        self._wanted = [0.0, 0.0]
        self._now = self.now()
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._plant.halt()
        return RTC_OK

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        self._plant.halt()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Move on, and send angles and pose."""
        config, plant = self.config, self._plant
        now = self.now()
        dt = (now - self._now) / SECOND
        self._now = now
        plant.roll(dt)
        if plant.touches:
            return self.fail(contact(plant))
        command = self._command.read_newest(now)
        if command is None:
            if self._command.is_late(now):
                self._wanted = [0.0, 0.0]
        else:
            if len(command.data) != len(self._wanted):
                return self.fail(f"WheelSpeed: {len(command.data)} speeds for 2 wheels")
            self._wanted = list(command.data)
        plant.drive(self._wanted, config.Velocity_limit, config.Acceleration_limit * dt)
        count = tau / config.EncoderCount
        angles = rtc.TimedDoubleSeq(
            data=[counted(angle, count) for angle in plant.angles]
        )
        self.stamp(angles)
        self.WheelAngle.write(angles)
        pose = iis.TimedPose2D(data=pose_message(plant.pose))
        self.stamp(pose)
        self.pose.write(pose)
        return RTC_OK
