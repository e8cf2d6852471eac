"""Checks of values in `rtgen.toml`; each returns what is wrong with a value, or None."""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Iterable
from typing import Any

from rtgen.compiler.project.transport_names import TRANSPORTS
from rtgen.facts import file_names
from rtgen.facts.adapter_constants import constants

_MACRO = re.compile(r"[A-Za-z_]\w*", re.ASCII)

Check = Callable[[Any], str | None]
"""Function that returns the error in a value, or None."""


def is_macro(name: str) -> bool:
    """Return whether the name is a valid macro name."""
    return _MACRO.fullmatch(name) is not None


def text(value: Any) -> str | None:
    """Check a text that is not empty."""
    return None if isinstance(value, str) and value else "must be a string"


def texts(value: Any) -> str | None:
    """Check a list of texts."""
    fine = isinstance(value, list) and all(
        isinstance(item, str) and item for item in value
    )
    return None if fine else "must be a list of strings"


def path(value: Any) -> str | None:
    """Check a path."""
    if problem := text(value):
        return problem
    wrong = file_names.problem(value)
    return f"must be a path that a file can have: this {wrong}" if wrong else None


def paths(value: Any) -> str | None:
    """Check a list of paths."""
    if problem := texts(value):
        return problem
    wrong = next(filter(None, map(file_names.problem, value)), None)
    return f"must be paths that files can have: one {wrong}" if wrong else None


def flag(value: Any) -> str | None:
    """Check true or false."""
    return None if isinstance(value, bool) else "must be true or false"


def macros(value: list[str] | dict[str, str | int]) -> dict[str, str]:
    """Parse macros `NAME` or `NAME=VALUE` as in `-D`, or a table of them."""
    if isinstance(value, dict):
        return {name: str(item) for name, item in value.items()}
    pairs = (text.partition("=") for text in value)
    return {name: body if equals else "1" for name, equals, body in pairs}


def macro_definitions(value: Any) -> str | None:
    """Check macros."""
    fine = texts(value) is None or (
        isinstance(value, dict) and all(type(v) in (str, int) for v in value.values())
    )
    if not fine:
        return "must be a list of 'NAME=VALUE', or a table of names to values"
    value = macros(value)
    wrong = next((name for name in value if not is_macro(name)), None)
    return None if wrong is None else f"holds {wrong!r}, which is not an identifier"


def patterns(value: Any) -> str | None:
    """Check patterns of files with codes."""
    fine = isinstance(value, dict) and all(texts(v) is None for v in value.values())
    return None if fine else "must be a table of patterns of files to lists of codes"


def one_of(*choices: str) -> Check:
    """Return the check of one of some texts."""

    def check(value: Any) -> str | None:
        fine = isinstance(value, str) and value in choices
        return None if fine else "must be one of " + ", ".join(map(repr, choices))

    return check


def number(least: int, greatest: int) -> Check:
    """Return the check of an integer."""

    def check(value: Any) -> str | None:
        is_number = isinstance(value, int) and not isinstance(value, bool)
        fine = is_number and least <= value <= greatest
        return None if fine else f"must be a number from {least} to {greatest}"

    return check


room = number(1, 65535)
"""The check of a capacity."""


def until(value: Any) -> str | None:
    """Check the end of a run."""
    is_text = isinstance(value, int | float | str) and not isinstance(value, bool)
    return None if is_text else "must be seconds, or 'INSTANCE=STATE'"


def transport(value: Any) -> str | None:
    """Check the name of a transport."""
    if value in TRANSPORTS:
        return None
    from rtgen.compiler.kit import plugins

    names = [each.name for each in plugins.announced(plugins.Group.TRANSPORTS)]
    return None if value in names else one_of(*TRANSPORTS, *names)(value)


def partition(value: Any) -> str | None:
    """Check the name of a partition."""
    if problem := text(value):
        return problem
    from rtgen.runtime.distribution.medium import MediumError, check_name

    try:
        check_name(value)
    except MediumError as error:
        return f"is refused: {error}"
    return None


def factory(value: Any) -> str | None:
    """Check the place of a factory."""
    module, colon, name = value.partition(":") if isinstance(value, str) else ("",) * 3
    parts = [*module.split("."), *name.split(".")]
    fine = colon and all(
        part.isascii() and part.isidentifier() and not keyword.iskeyword(part)
        for part in parts
    )
    return None if fine else "must be 'module:attribute'"


def adapter(value: Any) -> str | None:
    """Check the table of an adapter."""
    form = (
        'from = "TYPE", to = "TYPE", map = { "MEMBER" = "MEMBER" }, '
        'set = { "MEMBER" = VALUE }, units = { "MEMBER" = ["UNIT", "UNIT"] }'
    )
    if not isinstance(value, dict):
        return f"must be a table: {form}"
    keys = ("from", "to", "map", "set", "units")
    unknown = next((key for key in value if key not in keys), None)
    if unknown is not None:
        return f"has an unknown key {unknown!r}; {did_you_mean(unknown, keys)}"
    source, target = value.get("from"), value.get("to")
    pairs, fixed, units = (value.get(key, {}) for key in ("map", "set", "units"))
    fine = (
        all(isinstance(each, dict) for each in (pairs, fixed, units))
        and all(isinstance(each, str) for each in (source, target, *pairs.values()))
        and is_constants(fixed)
        and all(map(_is_pair, units.values()))
    )
    return None if fine else f"must be a table: {form}"


def _is_pair(value: Any) -> bool:
    """Return whether the value is a list of two texts."""
    return isinstance(value, list) and [type(each) for each in value] == [str, str]


def is_constants(value: Any) -> bool:
    """Return whether the value is a table of constants."""
    try:
        constants(value)
    except ValueError:
        return False
    return True


def table(value: Any) -> str | None:
    """Check the options of a plug-in."""
    return None if isinstance(value, dict) else "must be a table of a plug-in's options"


_BREAKS = ("wire", "source", "stored", "compatible")


def breaks(value: Any) -> str | None:
    """Check kinds of breaks."""
    fine = isinstance(value, list) and all(v in _BREAKS for v in value)
    return None if fine else "must be a list of " + ", ".join(map(repr, _BREAKS))


def allowances(value: Any) -> str | None:
    """Check the allowed breaks: tables of texts."""
    fine = isinstance(value, list) and all(
        isinstance(each, dict)
        and {"code", "reason"} <= each.keys() <= {"code", "reason", "name", "path"}
        and all(isinstance(text, str) and text for text in each.values())
        for each in value
    )
    form = 'code = "DIF...", reason = "TEXT", and perhaps name = "PATTERN", path = "PATTERN"'
    return None if fine else f"must be tables: {form}"


class Problem(str):
    """An error in an entry of a table, with the key of the entry, perhaps a string in it."""

    entry: str
    hint: str | None
    item: str | None

    def __new__(
        cls, text: str, entry: str, hint: str | None = None, item: str | None = None
    ) -> Problem:
        problem = super().__new__(cls, text)
        problem.entry = entry
        problem.hint = hint
        problem.item = item
        return problem


def did_you_mean(name: str, keys: Iterable[str]) -> str:
    """Return the hint for an unknown name."""
    return near(name, keys) or "known: " + ", ".join(keys)


def near(name: str, keys: Iterable[str]) -> str | None:
    """Return the hint for a name that resembles a known one."""
    from difflib import get_close_matches

    close = get_close_matches(name.lower(), keys, n=1)
    return f"did you mean {close[0]!r}?" if close else None
