"""Conditional inclusion (ISO C 1998, 16.1): determines the active lines of a file."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.rules import lexical
from rtgen.compiler.frontends.idl.text import conditions
from rtgen.compiler.frontends.idl.text.macros import ExpansionError, Macro

_WORD = re.compile(r"[^\W\d]\w*")


class _Conditional(msgspec.Struct):
    """An open `#if`: whether its lines are active, and whether a branch has been taken."""

    span: Span
    outer: bool
    active: bool
    taken: bool
    otherwise: bool = False


class Conditionals:
    """The open conditionals of a file, the innermost last."""

    def __init__(self, report: Callable[[Diagnostic], None]) -> None:
        self._report = report
        self._open: list[_Conditional] = []

    @property
    def active(self) -> bool:
        """Whether lines are active."""
        return not self._open or self._open[-1].active

    @property
    def chooses(self) -> bool:
        """Whether an `#elif` can activate lines: those around the conditional are active."""
        return bool(self._open) and self._open[-1].outer

    def begin(
        self, name: str, rest: str, span: Span, macros: Mapping[str, Macro]
    ) -> None:
        """Process an `#if`, `#ifdef` or `#ifndef`."""
        outer = self.active
        value = False
        if outer:
            if name == "if":
                value = self._condition(rest, span, macros)
            elif match := _WORD.match(rest):
                value = (match[0] in macros) == (name == "ifdef")
            else:
                value = name == "ifndef"
                message = f"#{name} needs the name of a macro"
                hint = f"write #{name} NAME, or #if for an expression"
                self._report(lexical.NAMELESS_CONDITION.at(span, message, hint=hint))
        self._open.append(_Conditional(span, outer, outer and value, value))

    def proceed(
        self, name: str, rest: str, span: Span, macros: Mapping[str, Macro]
    ) -> None:
        """Process an `#elif`, `#else` or `#endif`."""
        if not self._open:
            message = f"#{name} without #if"
            hint = "remove it, or add the #if that is missing before it"
            self._report(lexical.STRAY_CONDITIONAL.at(span, message, hint=hint))
            return
        current = self._open[-1]
        if name == "endif":
            self._open.pop()
            return
        if current.otherwise:
            self._report(
                lexical.STRAY_CONDITIONAL.at(
                    span,
                    f"#{name} after #else",
                    related=[Related(current.span, "of this conditional")],
                    hint="an #if has one #else, which comes last",
                )
            )
            return
        if name == "else":
            current.otherwise = True
            current.active = current.outer and not current.taken
        elif current.taken or not current.outer:
            current.active = False
        else:
            current.active = self._condition(rest, span, macros)
        current.taken = current.taken or current.active

    def _condition(self, text: str, span: Span, macros: Mapping[str, Macro]) -> bool:
        try:
            return conditions.evaluate(text, macros)
        except ExpansionError as error:
            hint = "write an integer expression, such as defined(NAME) && VERSION >= 2"
            self._report(lexical.BAD_CONDITION.at(span, error.message, hint=hint))
            return False

    def end(self) -> None:
        """Process the end of the file: report conditionals that are still open."""
        for conditional in self._open:
            self._report(
                lexical.UNCLOSED_CONDITIONAL.at(
                    conditional.span,
                    "this conditional is never closed",
                    hint="add #endif at the end of the file",
                )
            )
