"""Driver calls the board of base.cdl through the component that rtgen makes of it."""

from __future__ import annotations

import logging

from two_wheels.components.driver import DriverBase
from two_wheels.rtc import Point2D, Pose2D, TimedPose2D
from two_wheels.tecs.base import WHEELS
from two_wheels.tecs.base.base_marshaller import BaseClientBase

from rtgen.runtime import RTC_OK, ReturnCode_t, ServiceError
from rtgen.runtime.opaque_rpc import E_OK, E_RPC, MERCD

log = logging.getLogger("driver")

RADIUS = 0.05
"""Of a wheel [m]."""
TREAD = 0.4
"""Between the wheels [m]."""


class Driver(DriverBase, BaseClientBase):
    """Drives the base at a speed, and tells where it is.

    The board may be missing, or be started anew: calls return an error meanwhile, and the next
    one connects again.
    """

    _is_connected: bool | None = None

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Send the speeds of the wheels, and publish the odometry of the reply."""
        forwards, sidewards = self.config.speed, self.config.turn * TREAD / 2
        speeds = [(forwards - sidewards) / RADIUS, (forwards + sidewards) / RADIUS]
        code, odometry = self.base.drive(speeds, WHEELS)
        is_connected = MERCD(code) != E_RPC
        if is_connected != self._is_connected:
            self._is_connected = is_connected
            name = self.base.identify()[1] if is_connected else "no board"
            log.warning("%s: %s", self.instance_name, name)
        if is_connected and code != E_OK:
            log.error("%s: the board refuses %s (%d)", self.instance_name, speeds, code)
            return ReturnCode_t.RTC_ERROR
        if is_connected:
            position = Point2D(x=odometry.x, y=odometry.y)
            pose = TimedPose2D(data=Pose2D(position=position, heading=odometry.heading))
            self.stamp(pose)
            self.pose.write(pose)
        return RTC_OK

    def on_deactivated(self, ec_id: int) -> ReturnCode_t:
        """Hold the wheels, if there are any."""
        try:
            self.base.stop()
        except ServiceError as error:
            log.warning("%s: the wheels are not held: %s", self.instance_name, error)
        return RTC_OK
