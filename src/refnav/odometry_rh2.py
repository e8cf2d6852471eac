"""OdometryRh2: the pose of the base from the angles of its wheels, corrected from outside."""

from __future__ import annotations

from refnav.geometry import Pose, wrap
from refnav.odometry import Odometer
from refrobots.components.odometry_rh2 import (
    OdometryRh2Base,
    OdometryRh2Configuration,
)
from rtgen.runtime import ReturnCode_t


class OdometryRh2(Odometer[OdometryRh2Configuration], OdometryRh2Base):
    """Takes over every pose of the localisation, and counts on from there."""

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Take over a pose from outside, then send the pose for new wheel angles."""
        localized = self.LocalizedPosition.read_newest()
        if localized is not None:
            data = localized.data
            self._reckoning.pose = Pose(
                data.position.x, data.position.y, wrap(data.heading)
            )
        return super().on_execute(ec_id)
