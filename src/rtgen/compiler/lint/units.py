"""Lint checks of units: unreadable ones, and factors that contradict a drive's objects."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from math import isclose
from typing import Final

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context, fields
from rtgen.compiler.model import Component, Interface
from rtgen.compiler.typemap.canopen.drive_units import (
    BY_DESCRIPTION,
    NoFactorError,
    drive_factor,
)
from rtgen.compiler.typemap.member_units import annotated_unit, is_number, unit_in

_SAME: Final = 1e-3
"""Relative difference up to which factors count as equal, since one may be rounded."""

_LIKE: Final = 0.85
"""Likeness to the name of a unit from which brackets in a comment are meant as one."""

_NO_UNITS: Final = ("n/a",)
"""Texts in brackets that are nearly units, and never meant as ones."""

_FORMS: Final = (
    "units are written like m/s^2, rad/s, kg*m^2, deg C, %; one of your own in braces: {steps}"
)


def texts(context: Context) -> Iterator[Diagnostic]:
    """Report texts of `@unit` and of bus files that do not denote a unit."""
    entries = list(_texts(context))
    comments = list(_comments(context))
    if not entries and not comments:
        return
    from rtgen.compiler.kit.units import UnitError, parse_list, suggestion

    for text, span in entries:
        try:
            parse_list(text)
        except UnitError as error:
            message = f"{text!r} is not a unit: {error}"
            meant = suggestion(text)
            if meant is not None:
                hint = f'did you mean "{meant}"?'
                yield rules.MISSPELT_UNIT.at(span, message, hint=hint)
            else:
                yield rules.UNKNOWN_UNIT.at(span, message, hint=_FORMS)
    for text, span in comments:
        try:
            parse_list(text)
        except UnitError as error:
            meant = suggestion(text, cutoff=_LIKE)
            if meant is not None:
                message = f"[{text}] in its comment is not a unit: {error}"
                hint = f"did you mean [{meant}]?"
                yield rules.MISSPELT_UNIT.at(span, message, hint=hint)


def _comments(context: Context) -> Iterator[tuple[str, Span]]:
    """Yield the texts in brackets of comments of numbers, which are units if they can be."""
    for declaration in context.declarations:
        for entry in fields(declaration):
            text = None if annotated_unit(entry) is not None else unit_in(entry.doc)
            if (
                text
                and text.lower() not in _NO_UNITS
                and is_number(context.model, entry.type)
            ):
                yield text, entry.span


def _texts(context: Context) -> Iterator[tuple[str, Span]]:
    for declaration in context.declarations:
        if isinstance(declaration, Component):
            stated = [
                *((port.unit, port.span) for port in declaration.ports),
                *((item.unit, item.span) for item in declaration.configuration),
            ]
            yield from (
                pair for pair in stated if pair[0] and context.is_given(pair[1].file)
            )
        operations = (
            declaration.operations if isinstance(declaration, Interface) else ()
        )
        parameters = (p for operation in operations for p in operation.parameters)
        for entry in chain(fields(declaration), parameters):
            unit = annotated_unit(entry)
            if unit is not None:
                yield unit, entry.span
    for bus in context.model.buses:
        for kind in bus.kinds:
            for _, unit in kind.units:
                if unit:
                    yield unit, kind.span


def factors(context: Context) -> Iterator[Diagnostic]:
    """Report factors of bus files that differ from those of the drive's own objects."""
    for bus in context.model.buses:
        for kind in bus.kinds:
            units = dict(kind.units)
            for number, stated in kind.factors:
                try:
                    computed = drive_factor(kind.device, number, units.get(number, ""))
                except NoFactorError:
                    continue
                if not isclose(stated, computed, rel_tol=_SAME):
                    yield rules.OTHER_FACTOR.at(
                        kind.span,
                        f"the factor of {number[0]:04X} is {stated}; by 608Fh, 6091h and "
                        f"60A8h to 60AAh it is {computed:.9g} {units[number]}",
                        hint=f'correct it, or write "{BY_DESCRIPTION}" for it',
                    )
