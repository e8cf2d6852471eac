"""SegwayJoystick: one stick, with small output near its centre."""

from __future__ import annotations

from refnav.joystick import Joystick, Response
from refrobots.components.segway_joystick import (
    SegwayJoystickBase,
    SegwayJoystickConfiguration,
)


class SegwayJoystick(Joystick[SegwayJoystickConfiguration], SegwayJoystickBase):
    """One stick, with small output near its centre."""

    response = Response(power=2.0)
