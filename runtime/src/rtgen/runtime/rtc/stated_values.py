"""Texts of parameters of other processes, judged by the type and constraint that these state."""

from __future__ import annotations

from typing import Final

from rtgen.facts.parameter_words import STRING, canonical
from rtgen.runtime.errors import ConfigurationError, ParameterValueError
from rtgen.runtime.rtc.parameter_values import Converter
from rtgen.runtime.rtc.profiles import ParameterProfile

_WIDE: Final = {"long": "long long", "unsigned long": "unsigned long long"}
"""Types by their words in C++, where `long` has 64 bits on most machines."""


def problem(name: str, text: str, type_: str, constraint: str) -> str:
    """Return why a parameter cannot have a text; empty if it can, as far as is stated.

    `type_` is a word of C++ (`std::vector<double>`), `constraint` as in RTC.xml; a type or
    constraint that is empty, or not known, permits every text.
    """
    word = " ".join(type_.split())
    type_word = _WIDE.get(word.removesuffix(" int")) or canonical(word)
    if type_word is not None:
        return _refusal(name, text, type_word, constraint)
    is_number = not _refusal(name, text, "double", "")
    return _refusal(name, text, "double" if is_number else STRING, constraint)


def _refusal(name: str, text: str, type_: str, constraint: str) -> str:
    try:
        convert = Converter(
            ParameterProfile(name, name, type_, constraint=constraint), None
        )
    except ConfigurationError:
        return _refusal(name, text, type_, "") if constraint else ""
    try:
        convert(text)
    except ParameterValueError as error:
        return str(error)
    return ""
