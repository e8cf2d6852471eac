"""AistJoystick: a digital pad."""

from __future__ import annotations

from refnav.joystick import Joystick, Response
from refrobots.components.aist_joystick import (
    AistJoystickBase,
    AistJoystickConfiguration,
)


class AistJoystick(Joystick[AistJoystickConfiguration], AistJoystickBase):
    """a digital pad."""

    response = Response(digital=True)
