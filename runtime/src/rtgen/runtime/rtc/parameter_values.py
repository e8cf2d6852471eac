"""Converts texts of configuration parameters to values, by IDL type."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from enum import IntEnum
from typing import Any, TypeVar

from rtgen.facts import parameter_texts
from rtgen.facts.constraints import (
    ConstraintError,
    Value,
    allows,
    check_literals,
    parse,
)
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES, OCTET_TYPES
from rtgen.runtime.errors import ConfigurationError, ParameterValueError
from rtgen.runtime.rtc.profiles import ParameterProfile

T = TypeVar("T")

_SEQUENCE = re.compile(r"sequence<(?P<element>.+?)(?:,(?P<bound>\d+))?>")
_ARRAY = re.compile(r"(?P<element>[^\[\]]+)\[(?P<length>\d+)\]")
_STRING = re.compile(r"(?:w?string(?:<(?P<bound>\d+)>)?|(?P<char>w?char))")
_FIXED = re.compile(r"fixed<(?P<digits>\d+),(?P<scale>\d+)>")


class _RefusalError(Exception):
    """The reason why a text is invalid; the converter adds the parameter and the text."""


class Converter:
    """Converts and validates the texts of one parameter.

    `example` is a value of the parameter's Python type: it provides the class of an enumeration,
    and the kind of value if the profile's type is the name of an alias. Raises ConfigurationError
    for a malformed constraint.
    """

    def __init__(self, profile: ParameterProfile, example: object) -> None:
        self.profile = profile
        self._parse = _parser(profile.type, example)
        try:
            self._constraint = parse(profile.constraint)
            numeric = _is_numeric(profile.type, example)
            if self._constraint is not None and numeric is not None:
                check_literals(self._constraint, profile.type, numeric=numeric)
        except ConstraintError as reason:
            raise ConfigurationError(
                f"the constraint {profile.constraint!r} cannot be understood: {reason}"
            ) from None

    def __call__(self, text: str) -> Any:
        """Convert a text. Raises ParameterValueError with parameter, text and reason."""
        try:
            value = self._parse(text.strip())
            self._check(value)
        except _RefusalError as refusal:
            raise ParameterValueError(
                f"parameter {self.profile.name!r} cannot be {text.strip()!r}: {refusal}"
            ) from None
        return value

    def problem(self, text: str) -> str | None:
        """Return why a text is no value of the parameter; None if it is one."""
        try:
            self._check(self._parse(text.strip()))
        except _RefusalError as refusal:
            return str(refusal)
        return None

    def _check(self, value: Any) -> None:
        elements: list[Value] = (
            list(value) if isinstance(value, list | bytes) else [value]
        )
        for element in elements:
            self._check_range(element)
        if self._constraint is not None and not allows(self._constraint, elements):
            raise _RefusalError(f"its constraint is {self.profile.constraint}")

    def _check_range(self, element: Value) -> None:
        low, high = self.profile.minimum, self.profile.maximum
        if isinstance(element, str):
            return
        if low is not None and not element >= low:
            raise _RefusalError(f"it must be at least {low}{self._unit()}")
        if high is not None and not element <= high:
            raise _RefusalError(f"it must be at most {high}{self._unit()}")

    def _unit(self) -> str:
        return f" {self.profile.unit}" if self.profile.unit else ""


def _is_numeric(type_: str, example: object) -> bool | None:
    """Return whether the values, or their elements, are numbers; None if unknown."""
    if isinstance(example, IntEnum):
        return False
    if match := _SEQUENCE.fullmatch(type_) or _ARRAY.fullmatch(type_):
        first = example[0] if isinstance(example, list) and example else None
        return _is_numeric(match["element"].strip(), first)
    if type_ in INTEGER_RANGES or type_ in FLOAT_LIMITS or _FIXED.fullmatch(type_):
        return True
    if type_ == "boolean" or _STRING.fullmatch(type_):
        return False
    match example:
        case bool() | str():
            return False
        case int() | float() | Decimal():
            return True
        case [first, *_]:
            return _is_numeric("", first)
    return None


def _parser(type_: str, example: object) -> Callable[[str], Any]:
    if isinstance(example, IntEnum):
        return _enumeration(type(example))
    if match := _SEQUENCE.fullmatch(type_):
        bound = int(match["bound"]) if match["bound"] else None
        return _elements(match["element"].strip(), example, 0, bound)
    if match := _ARRAY.fullmatch(type_):
        length = int(match["length"])
        return _elements(match["element"].strip(), example, length, length)
    if type_ == "boolean":
        return _boolean
    if type_ in INTEGER_RANGES:
        return _integer(*INTEGER_RANGES[type_])
    if type_ in FLOAT_LIMITS:
        return _floating(FLOAT_LIMITS[type_])
    if match := _STRING.fullmatch(type_):
        bound = int(match["bound"]) if match["bound"] else None
        return _character if match["char"] else _string(bound)
    if match := _FIXED.fullmatch(type_):
        return _decimal(int(match["digits"]), int(match["scale"]))
    return _by_example(type_, example)


def _by_example(type_: str, example: object) -> Callable[[str], Any]:
    if isinstance(example, bool):
        return _boolean
    if isinstance(example, int):
        return _integer(-(2**63), 2**64 - 1)
    if isinstance(example, float):
        return _floating(math.inf)
    if isinstance(example, str):
        return _string(None)
    if isinstance(example, list):
        first = example[0] if example else 0.0
        return _elements("", first, 0, None)

    def refuse(text: str) -> Any:
        raise _RefusalError(f"a value of type {type_} cannot be given as text")

    return refuse


def _boolean(text: str) -> bool:
    return _read(parameter_texts.boolean, text)


def _read(read: Callable[[str], T], text: str) -> T:
    try:
        return read(text)
    except ValueError as reason:
        raise _RefusalError(str(reason)) from None


def _integer(low: int, high: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        value = _read(parameter_texts.integer, text)
        if not low <= value <= high:
            raise _RefusalError(f"it must be between {low} and {high}")
        return value

    return parse


def _floating(largest: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        value = _read(parameter_texts.number, text)
        if math.isfinite(value) and abs(value) > largest:
            raise _RefusalError(f"its size must be at most {largest:.8g}")
        return value

    return parse


def _decimal(digits: int, scale: int) -> Callable[[str], Decimal]:
    def parse(text: str) -> Decimal:
        try:
            value = Decimal(text)
        except InvalidOperation:
            raise _RefusalError("it must be a decimal number") from None
        if not value.is_finite() or abs(value) >= Decimal(10) ** (digits - scale):
            raise _RefusalError(
                f"it must have at most {digits - scale} digits before the point"
            )
        if value != round(value, scale):
            raise _RefusalError(f"it must have at most {scale} digits after the point")
        return value

    return parse


def _string(bound: int | None) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if "\0" in text:
            raise _RefusalError("it must not contain NUL")
        if bound is not None and len(text.encode()) > bound:
            raise _RefusalError(f"it must have at most {bound} octets")
        return text

    return parse


def _character(text: str) -> str:
    if len(text) != 1:
        raise _RefusalError("it must be one character")
    return text


def _enumeration(kind: type[IntEnum]) -> Callable[[str], IntEnum]:
    def parse(text: str) -> IntEnum:
        name = text.rpartition("::")[2]
        if name not in kind.__members__:
            raise _RefusalError(f"it must be one of {', '.join(kind.__members__)}")
        return kind[name]

    return parse


def _elements(
    type_: str, example: object, least: int, most: int | None
) -> Callable[[str], Any]:
    sample = (
        example[0] if isinstance(example, list | str | bytes) and example else example
    )
    parse_element = _parser(type_, sample)

    def parse(text: str) -> Any:
        items = parameter_texts.items(text)
        if len(items) < least or (most is not None and len(items) > most):
            expectation = f"{least}" if least == most else f"at most {most}"
            raise _RefusalError(
                f"it must have {expectation} elements, not {len(items)}"
            )
        values = []
        for position, item in enumerate(items, 1):
            try:
                values.append(parse_element(item))
            except _RefusalError as refusal:
                raise _RefusalError(
                    f"element {position}, {item!r}: {refusal}"
                ) from None
        if type_ in OCTET_TYPES:
            return bytes(values)
        return "".join(values) if type_ == "char" else values

    return parse
