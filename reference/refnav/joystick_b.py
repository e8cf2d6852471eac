"""JoystickB: three analogue axes."""

from __future__ import annotations

from refnav.joystick import Joystick, Response
from refrobots.components.joystick_b import JoystickBBase, JoystickBConfiguration


class JoystickB(Joystick[JoystickBConfiguration], JoystickBBase):
    """three analogue axes."""

    response = Response(sideways=True)
