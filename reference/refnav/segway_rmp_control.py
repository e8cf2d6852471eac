"""SegwayRmpControl: Segway RMP, on two driven wheels."""

from __future__ import annotations

from refnav.body import Body, on_two_wheels
from refnav.robot import Robot
from refrobots.components.segway_rmp_control import (
    SegwayRmpControlBase,
    SegwayRmpControlConfiguration,
)


class SegwayRmpControl(Robot[SegwayRmpControlConfiguration], SegwayRmpControlBase):
    """Segway RMP, on two driven wheels."""

    def _make_body(self) -> Body:
        return on_two_wheels(self.config)
