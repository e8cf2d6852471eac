"""Units: the meaning of texts, their compatibility, and texts as mere data."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import pint
import pytest
import usual_units
from hypothesis import given
from hypothesis import strategies as st
from packaging.version import Version

from rtgen.compiler.kit.units import (
    Relation,
    Unit,
    UnitError,
    conversion,
    parse,
    parse_list,
    relation,
    suggestion,
)
from rtgen.facts.unit_symbols import PHRASES, SYMBOLS, USUAL_NAMES, USUAL_SYMBOLS

SAME = [
    ("m/s", "m / s"),
    ("m/s", "m.s-1"),
    ("m/s", "m s^-1"),
    ("m/s", "m·s⁻¹"),
    ("m/s^2", "m/s²"),
    ("rad/s", "rad/sec"),
    ("rpm", "r/min"),
    ("rpm", "rev/min"),
    ("rpm", "U/min"),
    ("Nm", "N*m"),
    ("Nm", "J"),
    ("N", "kg m/s^2"),
    ("deg C", "°C"),
    ("deg", "°"),
    ("inc", "counts"),
    ("/s", "Hz"),
    ("J/(kg K)", "J/kg/K"),
    ("m/s/s", "m/s^2"),
    ("mNm", "0.001 Nm"),
    ("%", "0.01"),
    ("Ohm", "V/A"),
    ("l/min", "1e-3 m^3/min"),
    ("Cel", "deg C"),
    ("[degF]", "deg F"),
    ("[in_i]", "25.4 mm"),
    ("[in_i]/s", "in/s"),
    ("[in_i]2", "in^2"),
    ("10*3.m", "km"),
    ("10^-3 m", "mm"),
    ("10*-3.m/s", "mm/s"),
    ("{count}/s", "counts/s"),
    ("{person}/s", "Hz"),
    ("m{wheel}/s", "m/s"),
    ("m2{wheel}", "m²"),
    ("60 ''", "'"),
    ("G", "1e-4 T"),
    ("kG", "0.1 T"),
    ("[yd_i]", "3 [ft_i]"),
    ("16 [oz_av]", "[lb_av]"),
    ("wk", "7 d"),
    ("ar", "100 m2"),
    ("By", "8 bit"),
    ("2.[pi].rad", "rev"),
    ("circ/min", "rpm"),
    ("1000 [ppb]", "[ppm]"),
    ("ppb", "1000 [pptr]"),
    ("[ppth]", "‰"),
    ("mm[Hg]", "mmHg"),
    ("m[Hg]/s", "100 cm[Hg].s-1"),
    ("cm[H2O]", "98.0665 Pa"),
    ("1000.mm[H2O]", "m[H2O]"),
]
SCALED = [
    ("deg", "rad", math.pi / 180, 0.0),
    ("rpm", "rad/s", math.tau / 60, 0.0),
    ("mm", "m", 1e-3, 0.0),
    ("m", "mm", 1e3, 0.0),
    ("deg C", "K", 1.0, 273.15),
    ("deg C", "deg F", 1.8, 32.0),
    ("deg F", "deg C", 1 / 1.8, -160 / 9),
    ("0.1 rpm", "rpm", 0.1, 0.0),
    ("km/h", "m/s", 1 / 3.6, 0.0),
    ("bit/s", "kbit/s", 1e-3, 0.0),
    ("µm", "m", 1e-6, 0.0),
    ("mG", "uT", 0.1, 0.0),
    ("milligauss", "T", 1e-7, 0.0),
    ("AU", "km", 149597870.7, 0.0),
    ("[degR]", "K", 1 / 1.8, 0.0),
]
DIFFERENT = [
    ("m", "rad"),
    ("m", "m/s"),
    ("V", "A"),
    ("counts", "rad"),
    ("pixels", "m"),
    ("dB", "%"),
]
ANGLE = [("rad/s", "Hz"), ("rpm", "1/min"), ("m", "m/rad"), ("%", "rad")]
WRONG = [
    *("", " ", "-", "m/", "*m", "m//s", "m**", "(m", "m)", "()", "none", "m^0", "m^10"),
    *("1e400 m", "0 m", "__import__('os')", "9**9**9**9", "m^999999999", "m" * 81),
    *("NAN", "inf", "_", "__class__", "m_", "delta_", "mdB", "kNp", "and"),
    *("10*999", "10*", "10^", "{", "{}", "[]", "[no]", "m[", "{a{b}}", "m{"),
    *("m[Hg", "g[Hg]", "m[He]"),
    *("m;s", "m\ns!", "{0}", "\0", "Ym^9 Ym^9", "Qpc^9", "(" * 40 + "m" + ")" * 39),
]


@pytest.mark.parametrize(("first", "second"), SAME)
def test_two_texts_of_one_unit(first: str, second: str) -> None:
    assert relation(parse(first), parse(second)) is Relation.EQUAL
    assert relation(parse(second), parse(first)) is Relation.EQUAL


@pytest.mark.parametrize(("source", "target", "factor", "offset"), SCALED)
def test_two_scales_of_one_dimension(
    source: str, target: str, factor: float, offset: float
) -> None:
    assert relation(parse(source), parse(target)) is Relation.SCALED
    assert conversion(parse(source), parse(target)) == pytest.approx((factor, offset))


@pytest.mark.parametrize(("first", "second"), DIFFERENT)
def test_two_dimensions(first: str, second: str) -> None:
    assert relation(parse(first), parse(second)) is Relation.DIFFERENT


@pytest.mark.parametrize(("first", "second"), ANGLE)
def test_an_angle_more(first: str, second: str) -> None:
    assert relation(parse(first), parse(second)) is Relation.ANGLE


@pytest.mark.parametrize("text", WRONG)
def test_texts_that_are_no_units(text: str) -> None:
    with pytest.raises(UnitError):
        parse(text)


def test_units_of_several_members() -> None:
    assert parse_list("m, rad") == (parse("m"), parse("rad"))
    with pytest.raises(UnitError):
        parse_list("m,")


def test_every_symbol_of_ours_is_a_unit() -> None:
    for symbol in (*SYMBOLS, *PHRASES):
        assert isinstance(parse(symbol), Unit), symbol


def test_a_converted_factor_has_no_digits_of_a_division() -> None:
    assert conversion(parse("deg C"), parse("deg F")) == (1.8, 32.0)


@given(st.text(max_size=90) | st.text("mskgrad/*.^()0123456789-e °%²⁻,", max_size=90))
def test_any_text_is_a_unit_or_an_error(text: str) -> None:
    try:
        unit = parse(text)
    except UnitError:
        return
    assert math.isfinite(unit.factor)
    assert unit.factor > 0


_UNITS = st.sampled_from(sorted({text for pair in SAME for text in pair} | {"mm", "h"}))


@given(_UNITS, _UNITS, st.floats(-1e6, 1e6))
def test_there_and_back(first: str, second: str, value: float) -> None:
    one, other = parse(first), parse(second)
    if relation(one, other) not in (Relation.EQUAL, Relation.SCALED):
        assert one.dimension != other.dimension
        return
    factor, offset = conversion(one, other)
    back, rest = conversion(other, one)
    assert back * (factor * value + offset) + rest == pytest.approx(value, abs=1e-6)


MISSPELT = {
    "milimeter": "millimeter",
    "milimetre": "millimetre",
    "Newton": "newton",
    "celcius": "celsius",
    "amper": "ampere",
    "secound": "second",
    "degreess": "degree",
    "hz": "Hz",
    "KHz": "kHz",
    "Kg": "kg",
    "NM": "Nm",
    "KM/h": "km/h",
    "Kg*m/secnd^2": "kg*m/second^2",
    "meterr, newtn": "meter, newton",
    "metres per tick": "metres/tick",
    "Newton meters per rad": "newton meters/rad",
}


@pytest.mark.parametrize(("written", "meant"), MISSPELT.items())
def test_misspelt_units(written: str, meant: str) -> None:
    with pytest.raises(UnitError):
        parse_list(written)
    assert suggestion(written) == meant
    parse_list(meant)


@pytest.mark.parametrize(
    "text", ["foo", "steps", "wags per tick", "x", "", "m/", "rotation", "m/s^99"]
)
def test_texts_that_are_no_misspelt_units(text: str) -> None:
    assert suggestion(text) is None


@pytest.mark.parametrize("text", [*USUAL_SYMBOLS, *USUAL_NAMES])
def test_suggested_units_are_units(text: str) -> None:
    parse_list(text)


def test_usual_units_and_names_are_those_of_pint() -> None:
    stored = json.loads(usual_units.FILE.read_text("utf-8"))
    said = usual_units.content()
    assert list(stored["units"]) == list(said["units"])
    for symbol, unit in said["units"].items():
        kept = parse(symbol)
        assert kept.dimension == unit.dimension, symbol
        assert kept[1:] == pytest.approx(unit[1:]), symbol
    if Version(pint.__version__) <= Version(stored["pint"]):
        for kind in ("names", "prefixes"):
            assert set(said[kind].split()) <= set(stored[kind].split())


def test_usual_units_and_other_words_do_without_pint() -> None:
    script = (
        "import sys; from rtgen.compiler.kit.units import parse, UnknownSymbolError\n"
        "for text in ('m/s^2', 'deg C', 'mNm/rad', 'kHz', 'counts/rev'): parse(text)\n"
        "for word in ('cells', 'or', 'kwords'):\n"
        "    try: parse(word)\n"
        "    except UnknownSymbolError: pass\n"
        "    else: sys.exit(word)\n"
        "sys.exit('pint' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
