"""Constraint texts of configuration parameters, as RTC.xml and `conf.__constraints__` write them.

`100`, `x>=5`, `5<=x`, `0.0<x<=2.0`, `(a,b,c)`; for a sequence `x<1,x>=2` gives one constraint for
each element in turn, a single one holds for every element; `{k1:...,k2:...}` (hash) is left alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from rtgen.runtime.errors import ConfigurationError

Scalar = bool | int | float | str
Check = Callable[[Scalar], bool]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_ABOVE = re.compile(rf"x(<=?|>=?)({_NUMBER})")
_BELOW = re.compile(rf"({_NUMBER})(<=?|>=?)x")
_BETWEEN = re.compile(rf"({_NUMBER})(<=?)x(<=?)({_NUMBER})")
_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


def parse(text: str) -> tuple[Check, ...]:
    """The checks of a constraint text, none for an empty one.

    Raises ConfigurationError for a text that cannot be understood.
    """
    text = re.sub(r"\s", "", text)
    if not text or (text.startswith("{") and text.endswith("}")):
        return ()
    return tuple(_single(part) for part in _split(text))


def _split(text: str) -> list[str]:
    return re.split(r",(?![^(]*\))", text)


def _single(text: str) -> Check:
    if match := _BETWEEN.fullmatch(text):
        low, above, below, high = match.groups()
        lower, upper = _comparison(_TURNED[above], low), _comparison(below, high)
        return lambda value: lower(value) and upper(value)
    if match := _ABOVE.fullmatch(text):
        return _comparison(match[1], match[2])
    if match := _BELOW.fullmatch(text):
        return _comparison(_TURNED[match[2]], match[1])
    if text.startswith("(") and text.endswith(")"):
        choices = [_equality(item) for item in text[1:-1].split(",")]
        return lambda value: any(choice(value) for choice in choices)
    if re.search(r"[<>(){}]", text):
        raise ConfigurationError(f"the constraint {text!r} cannot be understood")
    return _equality(text)


def _comparison(operator: str, text: str) -> Check:
    bound = float(text)
    if operator == "<":
        return lambda value: not isinstance(value, str) and value < bound
    if operator == "<=":
        return lambda value: not isinstance(value, str) and value <= bound
    if operator == ">":
        return lambda value: not isinstance(value, str) and value > bound
    return lambda value: not isinstance(value, str) and value >= bound


def _equality(text: str) -> Check:
    def check(value: Scalar) -> bool:
        if isinstance(value, bool):
            return text.lower() in (("true", "1") if value else ("false", "0"))
        if isinstance(value, int | float) and re.fullmatch(_NUMBER, text):
            return value == float(text)
        return text == getattr(value, "name", str(value))

    return check
