"""JoystickA: one analogue stick."""

from __future__ import annotations

from refnav.joystick import Joystick, Response
from refrobots.components.joystick_a import JoystickABase, JoystickAConfiguration


class JoystickA(Joystick[JoystickAConfiguration], JoystickABase):
    """one analogue stick."""

    response = Response()
