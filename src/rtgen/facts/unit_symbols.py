"""Symbols of units of UCUM, data sheets, EDS files and IDL comments that SI does not define."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

SYMBOLS: Final[Mapping[str, str]] = {
    "Nm": "newton*meter",
    "mNm": "millinewton*meter",
    "uNm": "micronewton*meter",
    "µNm": "micronewton*meter",
    "kNm": "kilonewton*meter",
    "VA": "volt*ampere",
    "Ah": "ampere*hour",
    "mAh": "milliampere*hour",
    "Wh": "watt*hour",
    "mWh": "milliwatt*hour",
    "kWh": "kilowatt*hour",
    "r": "revolution",
    "rev": "revolution",
    "revs": "revolution",
    "U": "revolution",
    "turns": "revolution",
    "RPM": "rpm",
    "rps": "revolution/second",
    "Ohm": "ohm",
    "inc": "count",
    "incs": "count",
    "increment": "count",
    "increments": "count",
    "cnt": "count",
    "cnts": "count",
    "digit": "count",
    "digits": "count",
    "lsb": "count",
    "LSB": "count",
    "tick": "count",
    "ticks": "count",
    "pulse": "count",
    "pulses": "count",
    "px": "pixel",
    "sec": "second",
    "secs": "second",
    "\u2032": "arcminute",
    "\u2033": "arcsecond",
    "'": "arcminute",
    "''": "arcsecond",
    "Cel": "degC",
    "[degF]": "degF",
    "[degR]": "degR",
    "[in_i]": "inch",
    "[ft_i]": "foot",
    "[yd_i]": "yard",
    "[mi_i]": "mile",
    "[nmi_i]": "nautical_mile",
    "[kn_i]": "knot",
    "[lb_av]": "pound",
    "[oz_av]": "ounce",
    "[lbf_av]": "force_pound",
    "[gal_us]": "gallon",
    "[HP]": "horsepower",
    "[Btu_IT]": "Btu",
    "[psi]": "psi",
    "[ppm]": "ppm",
    "[pi]": "pi",
    "[c]": "speed_of_light",
    "[g]": "standard_gravity",
    "G": "magnetic_gauss",
    "gauss": "magnetic_gauss",
    "mG": "millimagnetic_gauss",
    "milligauss": "millimagnetic_gauss",
    "uG": "micromagnetic_gauss",
    "kG": "kilomagnetic_gauss",
    "AU": "astronomical_unit",
    "ar": "are",
    "By": "byte",
    "mo": "month",
    "wk": "week",
    "°": "degree",
    "%": "percent",
    "‰": "permille",
}
"""Definitions of symbols in pint's names; some, such as `Nm` and `U`, mean something else in
pint.
"""

PHRASES: Final[Mapping[str, str]] = {
    "deg C": "degC",
    "deg. C": "degC",
    "° C": "degC",
    "°C": "degC",
    "Celsius": "degC",
    "deg F": "degF",
    "°F": "degF",
}
"""Units written with several words or signs, and a single symbol for each."""

DEFINITIONS: Final = ("magnetic_gauss = 1e-4 * tesla",)
"""Further units in pint's notation: the gauss of pint is that of the Gaussian system, which cannot be
converted to tesla.
"""
