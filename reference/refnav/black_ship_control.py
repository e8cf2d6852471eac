"""BlackShipControl: Segway BlackShip, on two driven wheels."""

from __future__ import annotations

from refnav.body import Body, on_two_wheels
from refnav.robot import Robot
from refrobots.components.black_ship_control import (
    BlackShipControlBase,
    BlackShipControlConfiguration,
)


class BlackShipControl(Robot[BlackShipControlConfiguration], BlackShipControlBase):
    """Segway BlackShip, on two driven wheels."""

    def _make_body(self) -> Body:
        return on_two_wheels(self.config)
