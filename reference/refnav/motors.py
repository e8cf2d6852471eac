"""The motors of the reference build's drives, each with its load."""

from __future__ import annotations

from math import tau
from typing import Final

from refnav.axis import Motor

_RPM = tau / 60.0

MOTOR_CORE_UNIT: Final = Motor(
    inertia=0.2,
    friction=0.5,
    torque_constant=3.0,  # 30 N m at 10 A
    speed_constant=1.0 * _RPM,  # 60 rpm at 60 V
    supply=(10.0, 60.0),
    current=7.0,
)
"""Behind the gear; Tables 5 and 6 of the source document. The load is an arm of some 0.2 kg m^2."""

FTMD_WHEEL: Final = Motor(
    inertia=1.5e-3,
    friction=1e-3,
    torque_constant=1.0 / 7.0,
    speed_constant=50.0 * _RPM,
    supply=(10.0, 60.0),
    current=7.0,
)
"""A wheel of FourX behind its gear, with its share of the base; driver by Table 6."""

BEEGO_WHEEL: Final = Motor(
    inertia=2.5e-5,
    friction=1e-6,
    torque_constant=0.034,
    speed_constant=500.0 * _RPM,
    supply=(11.0, 24.0),
    current=5.0,
)
"""A wheel of beego at its motor, before the gear, with its share of the base."""
