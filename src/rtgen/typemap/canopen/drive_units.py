"""Physical units of a drive's objects (CiA 402-2: 608Fh, 6091h, 60A8h to 60AAh).

Increments are counted at the motor; a drive with positions in increments has its velocities there,
too. Angles are those of the driving shaft after the gear. Codes of units: CiA 303-2.
"""

from __future__ import annotations

from math import tau
from typing import Final

from rtgen.model.canopen import Device
from rtgen.units import Relation, Unit, UnitError, conversion, parse, relation

BY_DESCRIPTION: Final = "cia402"
"""Value of a factor in a bus file that is computed from the drive's objects."""

_POSITION, _VELOCITY, _ACCELERATION = (0x60A8, 0), (0x60A9, 0), (0x60AA, 0)
_INCREMENT: Final = 0xB5
_ANGLES: Final = {0x10: 1.0, 0x41: tau / 360, 0xB4: tau}
_TIMES: Final = {0x03: 1.0, 0x47: 60.0}
_ORDERS: Final = {
    **dict.fromkeys((0x6062, 0x6064, 0x6065, 0x6067, 0x607A, 0x607C, 0x60F4), 0),
    **dict.fromkeys((0x607B, 0x607D), 0),
    **dict.fromkeys((0x606B, 0x606C, 0x607F, 0x6081, 0x6082, 0x6099, 0x60FF), 1),
    **dict.fromkeys((0x6083, 0x6084, 0x6085, 0x609A, 0x60C5, 0x60C6), 2),
}
"""Objects with positions (0), velocities (1) and accelerations (2)."""


class NoFactorError(ValueError):
    """The description does not determine the meaning of the object's value."""


def drive_factor(device: Device, number: tuple[int, int], unit: str) -> float:
    """Return the factor to a unit: physical value = factor * value. Raises NoFactorError."""
    if not unit:
        raise NoFactorError("it has no unit in `units`")
    try:
        wanted = parse(unit)
    except UnitError as error:
        raise NoFactorError(f"{unit!r} is not a unit: {error}") from None
    order = _ORDERS.get(number[0])
    if order is None:
        raise NoFactorError("it is not a position, velocity or acceleration of CiA 402")
    own = _unit(device, order)
    if relation(own, wanted) in (Relation.DIFFERENT, Relation.ANGLE):
        kind = ("an angle", "an angle in time", "an angle in time squared")[order]
        raise NoFactorError(f"it is {kind}, which is not measured in {unit}")
    return conversion(own, wanted)[0]


def _unit(device: Device, order: int) -> Unit:
    """Return the unit of positions, velocities or accelerations at the driving shaft."""
    prefix, what, _ = _parts(_number(device, _POSITION))
    turns = _number(device, (0x6091, 1)), _number(device, (0x6091, 2))
    at_motor = what == _INCREMENT
    if order == 0:
        if at_motor:
            increments = _number(device, (0x608F, 1)), _number(device, (0x608F, 2))
            angle = tau * increments[1] / increments[0]
        else:
            angle = prefix * _known(_ANGLES, what)
    else:
        stated = device.find(*_ACCELERATION) is not None and order == 2
        number = _ACCELERATION if stated else _VELOCITY
        prefix, what, per = _parts(_number(device, number))
        angle = prefix * _known(_ANGLES, what) / _known(_TIMES, per)
    if at_motor:
        angle *= turns[1] / turns[0]
    dimension = (("radian", 1.0), ("second", float(-order)))
    return Unit(dimension if order else dimension[:1], angle)


def _parts(code: int) -> tuple[float, int, int]:
    """Split the code of a unit into prefix, numerator and denominator."""
    exponent = code >> 24 & 0xFF
    prefix = 10.0 ** (exponent - 0x100 if exponent & 0x80 else exponent)
    return prefix, code >> 16 & 0xFF, code >> 8 & 0xFF


def _number(device: Device, number: tuple[int, int]) -> int:
    variable = device.find(*number)
    value = None if variable is None else variable.current
    if not isinstance(value, int) or value <= 0:
        name = f"{number[0]:04X}h" + (f":{number[1]:X}" if number[1] else "")
        raise NoFactorError(f"{name} has no value above 0")
    return value


def _known(units: dict[int, float], code: int) -> float:
    if code not in units:
        raise NoFactorError(f"the unit {code:02X}h is not known")
    return units[code]
