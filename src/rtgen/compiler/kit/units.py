"""Units of measurement in `@unit`, in EDS files and in profiles.

A text is a product of symbols with exponents, as SI and UCUM write them: `m/s^2`, `rad.s-1`,
`kg*m²`, `0.001 rpm`, `J/(kg K)`, `10*3.m`, `[in_i]`. Units after a comma are those of several
members, in their order: `m, rad`. pint defines the symbols. Unlike in SI, an angle is a dimension
here, so that `rad/s` and `Hz` differ. What pint says about usual symbols is in `usual_units.json`,
as are the words that it knows: to import pint takes longer than to check a project.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from enum import Enum
from functools import cache, lru_cache
from math import inf, ulp
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rtgen.compiler.kit.resources import usual_units
from rtgen.facts.unit_symbols import (
    DEFINITIONS,
    PHRASES,
    SYMBOLS,
    USUAL_NAMES,
    USUAL_SYMBOLS,
)

if TYPE_CHECKING:
    from pint import UnitRegistry

_MAX_LENGTH: Final = 80
_HIGHEST_POWER: Final = 9
_SHORTEST_WORD: Final = 4
_MAX_CORRECTIONS: Final = 8
_SUPERSCRIPTS: Final = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻·⋅\u00d7", "0123456789-***")
_TOKEN: Final = re.compile(
    r"\s*(?:10[*^](?P<order>[+-]?\d+)|(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)"
    r"|(?P<symbol>[cm]?m\[H(?:g|2O)\]|[^\W\d]+|\[[a-zA-Z_]+\]|''|[%‰°'\u2032\u2033])"
    r"(?:(?:\^|\*\*)?(?P<power>[+-]?\d+))?(?:\{[^\W\d][\w ]*\})?"
    r"|\{(?P<note>[^\W\d][\w ]*)\}|(?P<sign>[*/.()]))\s*"
)
_PER: Final = re.compile(r"(?<=\S)\s+per\s+(?=\S)")
_ANGLE: Final = "radian"
_TOLERANCE: Final = 1e-9


class Unit(NamedTuple):
    """A unit: value in base units = `factor` * value + `offset`.

    `dimension` has the exponent of each base unit, in order of their names.
    """

    dimension: tuple[tuple[str, float], ...]
    factor: float
    offset: float = 0.0


class Relation(Enum):
    """How two units are related."""

    EQUAL = "equal"
    SCALED = "scaled"
    ANGLE = "angle"
    """They differ by an angle, which SI does not count as a dimension: `rad/s` and `1/s`."""
    DIFFERENT = "different"


class UnitError(ValueError):
    """A text that does not denote a unit."""


class UnknownSymbolError(UnitError):
    """A symbol that does not denote a unit."""

    def __init__(self, symbol: str) -> None:
        super().__init__(f"the unit `{symbol}` is not known")
        self.symbol = symbol


def suggestion(text: str, cutoff: float = 0.75) -> str | None:
    """Return the text of units that a text with unknown symbols was likely meant as.

    `cutoff` is the least likeness of a symbol to a unit's name, from 0 to 1.
    """
    text = _PER.sub("/", text)
    for _ in range(_MAX_CORRECTIONS):
        try:
            parse_list(text)
        except UnknownSymbolError as error:
            near = _nearest(error.symbol, cutoff)
            if near is None:
                return None
            text = re.sub(
                rf"(?<![^\W\d_]){re.escape(error.symbol)}(?![^\W\d_])", near, text
            )
        except UnitError:
            return None
        else:
            return text
    return None


def _nearest(symbol: str, cutoff: float) -> str | None:
    """Return the usual unit of this name: in another case, or with few other letters."""
    folded = symbol.lower()
    for unit in (*USUAL_SYMBOLS, *USUAL_NAMES):
        if unit.lower() == folded:
            return unit
    if len(symbol) < _SHORTEST_WORD:
        return None
    from difflib import get_close_matches

    return next(iter(get_close_matches(folded, USUAL_NAMES, n=1, cutoff=cutoff)), None)


@lru_cache(1024)
def parse(text: str) -> Unit:
    """Parse the text of a unit. Raises UnitError."""
    plain = text.strip()
    if len(plain) > _MAX_LENGTH:
        raise UnitError(
            f"it has {len(plain)} characters, {_MAX_LENGTH} at most are read"
        )
    for phrase, symbol in PHRASES.items():
        plain = plain.replace(phrase, symbol)
    tokens = list(_tokens(plain.translate(_SUPERSCRIPTS)))
    if len(tokens) == 1 and tokens[0].group("power") is None:
        symbol = tokens[0].group("symbol")
        if symbol:
            return _symbol(symbol)
    try:
        unit, end = _product(tokens, 0)
    except OverflowError:
        raise UnitError("its factor is 0 or too large") from None
    if end < len(tokens):
        raise UnitError(f"`{tokens[end].group().strip()}` is not expected")
    return unit


def parse_list(text: str) -> tuple[Unit, ...]:
    """Parse units separated by commas. Raises UnitError."""
    return tuple(parse(part) for part in text.split(","))


def relation(first: Unit, second: Unit) -> Relation:
    """Return how two units are related."""
    if first.dimension == second.dimension:
        factor, offset = conversion(first, second)
        same = abs(factor - 1) <= _TOLERANCE and abs(offset) <= _TOLERANCE
        return Relation.EQUAL if same else Relation.SCALED
    if _without_angle(first) == _without_angle(second):
        return Relation.ANGLE
    return Relation.DIFFERENT


def conversion(source: Unit, target: Unit) -> tuple[float, float]:
    """Return factor and offset: value in the target's unit = factor * value + offset."""
    if source == target:
        return 1.0, 0.0
    offset = (source.offset - target.offset) / target.factor
    return _round_off(source.factor / target.factor), round(offset, 9)


def _round_off(number: float) -> float:
    """Round off the last digits of a division: 1.7999999999999998 becomes 1.8."""
    short = float(f"{number:.12g}")
    return short if abs(short - number) <= 4 * ulp(number) else number


def _without_angle(unit: Unit) -> tuple[tuple[str, float], ...]:
    return tuple(pair for pair in unit.dimension if pair[0] != _ANGLE)


def _tokens(text: str) -> Iterator[re.Match[str]]:
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise UnitError(f"{text[place]!r} is not expected")
        yield match
        place = match.end()
    if not text:
        raise UnitError("it is empty")


def _product(tokens: list[re.Match[str]], start: int) -> tuple[Unit, int]:
    """Parse factors from the token at `start`, up to the end or to a closing bracket."""
    product: Unit | None = None
    place, power = start, 1
    while place < len(tokens) and tokens[place].group("sign") != ")":
        token = tokens[place]
        sign = token.group("sign")
        if sign in ("*", "/", "."):
            if product is None and sign == "/":
                product = Unit((), 1.0)
            if product is None or place + 1 == len(tokens):
                raise UnitError(f"there is no unit beside `{sign}`")
            power, place = (-1 if sign == "/" else 1), place + 1
            if tokens[place].group("sign") not in (None, "("):
                raise UnitError(f"there is no unit beside `{sign}`")
        factor, place = _factor(tokens, place)
        factor = _raised(factor, power)
        product, power = factor if product is None else _times(product, factor), 1
    if product is None:
        raise UnitError("a unit is expected")
    return product, place


def _factor(tokens: list[re.Match[str]], place: int) -> tuple[Unit, int]:
    token = tokens[place]
    if token.group("sign") == "(":
        inner, end = _product(tokens, place + 1)
        if end == len(tokens):
            raise UnitError("a bracket is not closed")
        return inner, end + 1
    if token.group("note"):
        return _noted(token.group("note")), place + 1
    if token.group("order"):
        return _checked(Unit((), 10.0 ** int(token.group("order")))), place + 1
    if token.group("number"):
        return _checked(Unit((), float(token.group("number")))), place + 1
    power = int(token.group("power") or 1)
    if abs(power) > _HIGHEST_POWER or power == 0:
        raise UnitError(f"an exponent is from 1 to {_HIGHEST_POWER}")
    return _raised(_symbol(token.group("symbol")), power), place + 1


def _noted(note: str) -> Unit:
    """Return the unit of an annotation of UCUM: `{count}` is a count, `{person}` is one."""
    try:
        return _symbol(note)
    except UnitError:
        return Unit((), 1.0)


def _raised(unit: Unit, power: int) -> Unit:
    if power == 1:
        return unit._replace(offset=0.0)
    dimension = tuple((name, exponent * power) for name, exponent in unit.dimension)
    return _checked(Unit(dimension, unit.factor**power))


def _times(first: Unit, second: Unit) -> Unit:
    exponents = dict(first.dimension)
    for name, exponent in second.dimension:
        exponents[name] = exponents.get(name, 0) + exponent
    dimension = tuple(sorted((n, e) for n, e in exponents.items() if e))
    return _checked(Unit(dimension, first.factor * second.factor))


def _checked(unit: Unit) -> Unit:
    if not 0 < unit.factor < inf:
        raise OverflowError
    return unit


class _Usual(NamedTuple):
    """Units by symbol, and the names of all of pint's units and prefixes."""

    units: dict[str, Unit]
    names: frozenset[str]
    prefixes: tuple[str, ...]

    def may_know(self, symbol: str) -> bool:
        """Return whether a symbol may be a name with or without a prefix, or its plural."""
        rests = (
            symbol.removeprefix(prefix)
            for prefix in ("", *self.prefixes)
            if symbol.startswith(prefix)
        )
        return any(
            rest in self.names or rest.removesuffix("s") in self.names for rest in rests
        )


@cache
def _usual() -> _Usual:
    content = usual_units()
    units = {
        symbol: Unit(tuple((n, e) for n, e in dimension), factor, offset)
        for symbol, (dimension, factor, offset) in content["units"].items()
    }
    names, prefixes = content["names"].split(), content["prefixes"].split()
    return _Usual(units, frozenset(names), tuple(prefixes))


@lru_cache(1024)
def _symbol(symbol: str) -> Unit:
    usual = _usual()
    unit = usual.units.get(symbol)
    if unit is not None:
        return unit
    if not usual.may_know(symbol):
        raise UnknownSymbolError(symbol)
    return _defined_by_pint(symbol)


def _defined_by_pint(symbol: str) -> Unit:
    from pint import PintError

    name = SYMBOLS.get(symbol, symbol)
    # `name in registry` would evaluate an expression: NAN is a number there, and _ an attribute.
    if name == symbol and not _registry().parse_unit_name(name):
        raise UnknownSymbolError(symbol)
    try:
        return _unit_of(name)
    except PintError:  # for example, pint has no mdB
        raise UnitError(f"the unit `{symbol}` takes no prefix") from None


def _unit_of(name: str) -> Unit:
    registry = _registry()
    offset, one, two = (_in_root_units(value, name) for value in (0.0, 1.0, 2.0))
    if abs(two - 2 * one + offset) > _TOLERANCE * abs(two):
        return Unit(((name, 1.0),), 1.0)  # a logarithmic unit: dB
    factor = _in_root_units(1.0, f"delta_{name}") if offset else one
    exponents: list[tuple[str, Any]] = list(
        registry.Quantity(1.0, name).to_root_units().unit_items()
    )
    dimension = tuple(sorted((n, float(exponent)) for n, exponent in exponents))
    return Unit(dimension, factor, offset)


def _in_root_units(value: float, name: str) -> float:
    return _registry().Quantity(value, name).to_root_units().magnitude


@cache
def _registry() -> UnitRegistry[float]:
    import pint

    registry: UnitRegistry[float] = pint.UnitRegistry(
        cache_folder=None, autoconvert_offset_to_baseunit=True
    )
    for definition in DEFINITIONS:
        registry.define(definition)
    return registry
