"""SegwayJoystick: one stick, gentle round its middle."""

from __future__ import annotations

from refnav.joystick import Joystick, Response
from refrobots.components.segway_joystick import (
    SegwayJoystickBase,
    SegwayJoystickConfiguration,
)


class SegwayJoystick(Joystick[SegwayJoystickConfiguration], SegwayJoystickBase):
    """one stick, gentle round its middle."""

    response = Response(power=2.0)
