"""OdometryRh2: the pose of the base from the angles of its wheels, corrected from outside."""

from __future__ import annotations

from typing import Any

from refnav.geometry import Pose, wrap
from refnav.messages import pose_of
from refnav.newest import Newest
from refnav.odometry import Odometer
from refrobots import iis
from refrobots.components.odometry_rh2 import (
    OdometryRh2Base,
    OdometryRh2Configuration,
)
from rtgen.runtime import ReturnCode_t


class OdometryRh2(Odometer[OdometryRh2Configuration], OdometryRh2Base):
    """Adopts every pose of the localisation, and integrates from there.

    It sends no pose before the first one of the localisation.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of the localisation, too."""
        config = self.config
        self._localized = Newest[iis.TimedPose2D](
            self.LocalizedPosition, lambda: config.LocalizationTimeout
        )
        return super().on_initialize()

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Wait for a pose of the localisation."""
        self._localized.start(self.now())
        self._begun = False
        return super().on_activated(ec_id)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Adopt a pose of the localisation, then send the pose for new wheel angles."""
        localized = self._localized.read_newest(self.now())
        if localized is not None:
            pose = pose_of(localized.data)
            self._reckoning.pose = Pose(pose.x, pose.y, wrap(pose.theta))
            self._begun = True
        return super().on_execute(ec_id)

    @property
    def _inputs(self) -> tuple[Newest[Any], ...]:
        return self._wheels, self._localized

    @property
    def _is_localized(self) -> bool:
        return self._begun
