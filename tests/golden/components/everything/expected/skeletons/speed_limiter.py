# Created once by rtgen 0.1.0 from SpeedLimiter.idl.
# Yours to edit: rtgen never touches it again.
"""SpeedLimiter: Limits a "speed" """

from __future__ import annotations

from robots import lab
from robots.components.speed_limiter import SpeedLimiterBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class LeftBrakeServant(lab.Brake):
    """Executes the calls of the provider `left_brake`."""

    @property
    def braking(self) -> lab.Mode:
        raise NotImplementedError

    @property
    def force(self) -> float:
        raise NotImplementedError

    @force.setter
    def force(self, value: float) -> None:
        raise NotImplementedError

    def ping(self) -> bool:
        raise NotImplementedError

    def engage(self, force: float, from_: str) -> tuple[bool, str, float]:
        """Brakes; `left` is the remaining force."""
        raise NotImplementedError

    def release(self) -> None:
        raise NotImplementedError


class RightBrakeServant(lab.Brake):
    """Executes the calls of the provider `right_brake`."""

    @property
    def braking(self) -> lab.Mode:
        raise NotImplementedError

    @property
    def force(self) -> float:
        raise NotImplementedError

    @force.setter
    def force(self, value: float) -> None:
        raise NotImplementedError

    def ping(self) -> bool:
        raise NotImplementedError

    def engage(self, force: float, from_: str) -> tuple[bool, str, float]:
        """Brakes; `left` is the remaining force."""
        raise NotImplementedError

    def release(self) -> None:
        raise NotImplementedError


class SpeedLimiter(SpeedLimiterBase):
    """Limits a commanded speed.

    What is above the limit is clipped or dropped: "as configured", <always>.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Called once, when it is created."""
        self.left_brake.set_servant(LeftBrakeServant())
        self.right_brake.set_servant(RightBrakeServant())
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
