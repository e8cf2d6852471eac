"""RefHardControl: Ref-Hard, on two driven wheels."""

from __future__ import annotations

from refnav.body import Body, on_two_wheels
from refnav.robot import Robot
from refrobots.components.ref_hard_control import (
    RefHardControlBase,
    RefHardControlConfiguration,
)


class RefHardControl(Robot[RefHardControlConfiguration], RefHardControlBase):
    """Ref-Hard, on two driven wheels."""

    def _make_body(self) -> Body:
        return on_two_wheels(self.config)
