"""OmniWheelControl: Omni-Wheel, on omni-wheels."""

from __future__ import annotations

from refnav.body import Body, on_omni_wheels
from refnav.robot import Robot
from refrobots.components.omni_wheel_control import (
    OmniWheelControlBase,
    OmniWheelControlConfiguration,
)


class OmniWheelControl(Robot[OmniWheelControlConfiguration], OmniWheelControlBase):
    """Omni-Wheel, on omni-wheels."""

    def _make_body(self) -> Body:
        return on_omni_wheels(self.config)
