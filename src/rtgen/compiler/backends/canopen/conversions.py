"""Conversions between fields of codecs, values of the object dictionary, and members of samples.

Each function maps a Python expression to the converted one; `time` is the class of
`RTC::Time`. Most values need no conversion. Exceptions: physical values (by a factor), times
(48 bits in a codec, nanoseconds in the object dictionary), UNICODE_STRING (octets in a codec), and
values from the bus that their type in IDL cannot have: a text ends at its first zero, others raise
PdoError.
"""

from __future__ import annotations

from rtgen.compiler.backends.kit.quoting.python import (
    Python,
    number_literal,
    string_literal,
)
from rtgen.compiler.model.canopen import SIGNED, UNSIGNED, DataType
from rtgen.compiler.typemap.canopen.ports import Quantity

_REALS = (DataType.REAL32, DataType.REAL64)
_SECONDS: dict[int, str] = {
    DataType.TIME_OF_DAY: "_pdo.seconds_of_day",
    DataType.TIME_DIFFERENCE: "_pdo.seconds",
}
_BITS: dict[int, str] = {
    DataType.TIME_OF_DAY: "_pdo.day_bits",
    DataType.TIME_DIFFERENCE: "_pdo.time_bits",
}
_SECOND = "1_000_000_000"


def is_plain(quantity: Quantity) -> bool:
    """Return whether codecs and samples represent the value equally."""
    code = quantity.variable.data_type
    other = code in _SECONDS or code == DataType.UNICODE_STRING
    return quantity.factor is None and not other


def from_codec(quantity: Quantity, value: str, bits: int, time: str) -> Python:
    """Return a member of a sample, from a codec's field of `bits` bits."""
    variable = quantity.variable
    code, name = variable.data_type, string_literal(quantity.name)
    if variable.bits is not None and bits > variable.bits:
        limits = _limits(code, variable.bits)
        value = f"_pdo.within({name}, {value}, {limits})" if limits else value
    if quantity.factor is not None:
        return Python(f"{value} * {number_literal(quantity.factor)}")
    if code in _SECONDS:
        return Python(f"{time}(*{_SECONDS[code]}({name}, {value}))")
    if code == DataType.UNICODE_STRING:
        return Python(f"_pdo.wide_text({name}, {value})")
    return Python(value)


def _limits(code: int, bits: int) -> str:
    if code in SIGNED:
        return f"{-1 << bits - 1}, {(1 << bits - 1) - 1}"
    return f"0, {(1 << bits) - 1}" if code in UNSIGNED or code in _SECONDS else ""


def to_codec(quantity: Quantity, value: str) -> Python:
    """Return a codec's field, from a member of a sample."""
    code = quantity.variable.data_type
    name = string_literal(quantity.name)
    if quantity.factor is not None:
        return _unscaled(quantity, value)
    if code in _SECONDS:
        return Python(f"{_BITS[code]}({name}, {value}.sec, {value}.nsec)")
    if code == DataType.UNICODE_STRING:
        return Python(f"_pdo.wide_octets({name}, {value})")
    return Python(value)


def from_object(quantity: Quantity, value: str, time: str) -> Python:
    """Return a member of a sample, from a value of the object dictionary."""
    if quantity.factor is not None:
        return Python(f"{value} * {number_literal(quantity.factor)}")
    code = quantity.variable.data_type
    if code in _SECONDS:
        return Python(
            f"{time}(*_pdo.seconds_of({string_literal(quantity.name)}, {value}))"
        )
    if code in (DataType.VISIBLE_STRING, DataType.UNICODE_STRING):
        return Python(f"_pdo.terminated({value})")
    return Python(value)


def to_object(quantity: Quantity, value: str) -> Python:
    """Return a value of the object dictionary, from a member of a sample."""
    if quantity.factor is not None:
        return _unscaled(quantity, value)
    if quantity.variable.data_type in _SECONDS:
        return Python(f"_pdo.nanoseconds({value})")
    return Python(value)


def stamp(time: str) -> Python:
    """Return the time stamp of a sample, from `now` in ns."""
    return Python(f"{time}(*divmod(now, {_SECOND}))")


def _unscaled(quantity: Quantity, value: str) -> Python:
    factor = number_literal(quantity.factor or 1.0)
    if quantity.variable.data_type in _REALS:
        return Python(f"_pdo.quotient({value}, {factor})")
    return Python(f"_pdo.unscaled({string_literal(quantity.name)}, {value}, {factor})")
