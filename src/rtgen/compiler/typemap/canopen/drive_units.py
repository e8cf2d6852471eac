"""Physical units of a drive's objects (CiA 402-2: 608Fh, 6090h to 6092h, 60A8h to 60AAh).

Increments are counted at the motor; a drive with positions in increments has its velocities there,
too. Angles are those of the driving shaft after the gear, lengths are what that shaft moves. Codes
of units: CiA 303-2.
"""

from __future__ import annotations

from math import tau
from typing import Final

from rtgen.compiler.kit.units import (
    Relation,
    Unit,
    UnitError,
    conversion,
    parse,
    relation,
)
from rtgen.compiler.model.canopen import Device

BY_DESCRIPTION: Final = "cia402"
"""Value of a factor in a bus file that is computed from the drive's objects."""

_POSITION, _VELOCITY, _ACCELERATION = (0x60A8, 0), (0x60A9, 0), (0x60AA, 0)
_INCREMENT: Final = 0xB5
_METRE: Final = 0x01
_ANGLES: Final = {0x10: 1.0, 0x41: tau / 360, 0xB4: tau}
_TIMES: Final = {0x03: 1.0, 0x47: 60.0, 0x57: 1.0}
_ENCODER, _VELOCITY_ENCODER, _GEAR, _FEED = 0x608F, 0x6090, 0x6091, 0x6092
_LENGTH, _ANGLE = "meter", "radian"
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
        target = parse(unit)
    except UnitError as error:
        raise NoFactorError(f"{unit!r} is not a unit: {error}") from None
    order = _ORDERS.get(number[0])
    if order is None:
        raise NoFactorError("it is not a position, velocity or acceleration of CiA 402")
    own = _unit(device, order)
    if relation(own, target) is Relation.DIFFERENT:
        own = _along_the_feed(device, own)
    if relation(own, target) in (Relation.DIFFERENT, Relation.ANGLE):
        what = "a length" if own.dimension[0][0] == _LENGTH else "an angle"
        kind = what + ("", " in time", " in time squared")[order]
        raise NoFactorError(f"it is {kind}, which is not measured in {unit}")
    return conversion(own, target)[0]


def _unit(device: Device, order: int) -> Unit:
    """Return the unit of positions, velocities or accelerations."""
    position = _parts(_number(device, _POSITION))
    prefix, what, per = position
    if order:
        stated = device.find(*_ACCELERATION) is not None and order == 2
        number = _ACCELERATION if stated else _VELOCITY
        prefix, what, per = _parts(_number(device, number))
        prefix /= _factor_of(_TIMES, per)
    if what == _METRE:
        return _measured(_LENGTH, order, prefix)
    if what == _INCREMENT:
        encoder = _VELOCITY_ENCODER if order else _ENCODER
        if order and device.find(encoder, 1) is None:
            encoder = _ENCODER
        increments, turns = _ratio(device, encoder)
        angle = prefix * tau * turns / increments
    else:
        angle = prefix * _factor_of(_ANGLES, what)
    if _INCREMENT in (what, position[1]):
        motor, shaft = _ratio(device, _GEAR)
        angle *= shaft / motor
    return _measured(_ANGLE, order, angle)


def _measured(dimension: str, order: int, factor: float) -> Unit:
    times = (("second", float(-order)),) if order else ()
    return Unit(((dimension, 1.0), *times), factor)


def _along_the_feed(device: Device, unit: Unit) -> Unit:
    """Convert angles of the driving shaft to lengths, or back, if 6092h says how far it moves."""
    prefix, what, _ = _parts(_number(device, _POSITION))
    if what != _METRE or device.find(_FEED, 1) is None:
        return unit
    feed, turns = _ratio(device, _FEED)
    per_angle = feed * prefix / (tau * turns)
    (dimension, power), *times = unit.dimension
    if dimension == _LENGTH:
        return Unit(((_ANGLE, power), *times), unit.factor / per_angle)
    return Unit(((_LENGTH, power), *times), unit.factor * per_angle)


def _ratio(device: Device, index: int) -> tuple[int, int]:
    return _number(device, (index, 1)), _number(device, (index, 2))


def _parts(code: int) -> tuple[float, int, int]:
    """Split the code of a unit into prefix, numerator and denominator."""
    exponent = code >> 24 & 0xFF
    prefix = 10.0 ** (exponent - 0x100 if exponent & 0x80 else exponent)
    return prefix, code >> 16 & 0xFF, code >> 8 & 0xFF


def _number(device: Device, number: tuple[int, int]) -> int:
    value = device.number(*number)
    if value is None or value <= 0:
        name = f"{number[0]:04X}h" + (f":{number[1]:X}" if number[1] else "")
        raise NoFactorError(f"{name} has no value above 0")
    return value


def _factor_of(units: dict[int, float], code: int) -> float:
    if code not in units:
        raise NoFactorError(f"the unit {code:02X}h is not known")
    return units[code]
