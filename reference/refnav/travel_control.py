"""TravelControl: drives one of the robots of the experiments by travel commands."""

from __future__ import annotations

from collections.abc import Callable

from refnav.body import Body, on_omni_wheels, on_two_wheels
from refnav.geometry import Pose
from refnav.newest import Newest
from refrobots import iis
from refrobots.components.black_ship_control import BlackShipControlConfiguration
from refrobots.components.omni_wheel_control import OmniWheelControlConfiguration
from refrobots.components.ref_hard_control import RefHardControlConfiguration
from refrobots.components.segway_rmp_control import SegwayRmpControlConfiguration
from refrobots.components.travel_control import TravelControlBase
from rtgen.runtime import RTC_OK, SECOND, ReturnCode_t

BODIES: dict[str, Callable[[], Body]] = {
    "RefHard": lambda: on_two_wheels(RefHardControlConfiguration()),
    "SegwayRmp": lambda: on_two_wheels(SegwayRmpControlConfiguration()),
    "BlackShip": lambda: on_two_wheels(BlackShipControlConfiguration()),
    "OmniWheel": lambda: on_omni_wheels(OmniWheelControlConfiguration()),
}
"""The robots, with the default parameters of their own control components."""


class TravelControl(TravelControlBase):
    """Executes the newest command, and sends the velocity by the encoders.

    Its observable `truth` is the true pose (x, y, theta) [m, rad].
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the pose of the robot."""
        self._body: Body | None = None
        self._information = iis.TimedVelocity2D()
        config = self.config
        self._commands = Newest[iis.TimedVelocity2D](
            self.command, lambda: config.CommandTimeout
        )
        self.observables["truth"] = lambda: (
            () if self._body is None else self._body.plant.pose
        )
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start at rest; the robot stays at its place."""
        config = self.config
        if self._body is None:
            self._body = BODIES[config.robot]()
            self._body.place(Pose(config.start_x, config.start_y, config.start_theta))
        self._now = self.now()
        self._commands.start(self._now)
        self._command = (0.0, 0.0, 0.0)
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Brake: without the component the wheels are not driven."""
        return self._brake()

    def on_aborting(self, ec_id: int) -> ReturnCode_t:
        """Brake."""
        return self._brake()

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Move on, and report the motion since the last execution."""
        assert self._body is not None
        now = self.now()
        dt = (now - self._now) / SECOND
        self._now = now
        motion = self._body.roll(dt)
        self._listen(now)
        self._body.drive(*self._command, dt)
        if dt > 0.0:
            data = self._information.data
            data.vx, data.vy, data.va = (part / dt for part in motion)
            self.stamp(self._information)
            self.information.write(self._information)
        return RTC_OK

    def _brake(self) -> ReturnCode_t:
        if self._body is not None:
            self._body.halt()
        return RTC_OK

    def _listen(self, now: int) -> None:
        command = self._commands.read_newest(now)
        if command is not None and (command.tm.sec or command.tm.nsec):
            data = command.data
            self._command = (data.vx, data.vy, data.va)
        if self._commands.is_late(now):
            self._command = (0.0, 0.0, 0.0)
