"""Parses IDL text: an LALR(1) parser with error recovery.

After a syntax error the parser's stack is reset to the innermost list of declarations, the rest
of the broken declaration is skipped, and parsing continues after it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.syntax.builder import Builder
from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED, WORDS
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit import lalr
from rtgen.compiler.frontends.kit.grammars import load
from rtgen.compiler.frontends.kit.lalr import END, Token, token
from rtgen.compiler.frontends.kit.recovery import RecoveringParser

if TYPE_CHECKING:
    from rtgen.compiler.frontends.idl.syntax.syntax_errors import ErrorContext, Recovery

MAX_ERRORS = 50
"""Maximum number of syntax errors in a file; the rest of the file is then skipped."""

MAX_CLOSING_TOKENS = 1000
"""Maximum number of tokens supplied at the end of a truncated text to close open constructs."""

_MARKS = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n]){0,12}\'|[{};]', re.DOTALL)
_TEMPLATES = re.compile(
    r"""L?"(?:\\.|[^"\\\n])*"|L?'(?:\\.|[^'\\\n]){0,12}'|>>|<<|[<>;{}]|[^\s<>;{}"'\w]+|\w+""",
    re.DOTALL,
)
_TEMPLATE_WORDS = frozenset(
    ("sequence", "string", "wstring", "fixed", "map", "bitfield")
)
_OPENED = {"<": 1, ">": -1, ">>": -2}
_CLOSER = "\x01"
_DECLARED = re.compile(r"\b([^\W\d]\w*)(?=\s*(?:[;,{:(\[=}]|switch\b))")
_ENUMERATORS = re.compile(r"\benum\b[^{}]*\{([^{}]*)")
_NAME = re.compile(r"[^\W\d]\w*")


@cache
def _grammar() -> lalr.Grammar:
    return load("idl", Builder(), RESERVED)


def parse(unit: Unit, report: Callable[[Diagnostic], None]) -> tuple[tree.Item, ...]:
    """Parse a unit; declarations with syntax errors are left out. Never raises."""
    return _Run(unit, report).result()


class _Run:
    def __init__(self, unit: Unit, report: Callable[[Diagnostic], None]) -> None:
        self._unit = unit
        self._report = report
        self._text = _mark_closers(unit.text) if ">>" in unit.text else unit.text
        self._parser = RecoveringParser(_grammar(), self._text)
        self._errors = 0
        self._last_error = -1
        self._surplus = self._text.count("{") - self._text.count("}")
        self._mended: set[tuple[int, tuple[str, ...], int | None]] = set()
        self._blanks: set[str] = set()
        self._is_idl: bool | None = None

    def result(self) -> tuple[tree.Item, ...]:
        while True:
            try:
                items: tuple[tree.Item, ...] = self._parser.run()
                return items
            except lalr.UnexpectedTokenError as error:
                if self._is_foreign():
                    return ()
                self._unexpected(error.token)
            except lalr.UnexpectedCharacterError:
                if self._is_foreign():
                    return ()
                self._bad_character()

    def _is_foreign(self) -> bool:
        """Return whether the text is in another language, which is reported as one error."""
        if self._is_idl is None:
            from rtgen.compiler.frontends.idl.syntax.other_languages import (
                other_language,
            )

            unit = self._unit
            other = other_language(unit.text)
            self._is_idl = other is None
            if other is not None:
                language, start, end = other
                unit.lacking = True
                unit.events.clear()
                message = f"this is {language}"
                hint = "rtgen reads the IDL of OMG (CORBA, DDS): write the declarations in it"
                self._report(
                    syntax.OTHER_LANGUAGE.at(unit.span(start, end), message, hint=hint)
                )
        return not self._is_idl

    def _emit(self, diagnostic: Diagnostic, offset: int) -> None:
        """Report a diagnostic, unless one has been reported at the same place."""
        piece, begin = self._unit.piece(offset)
        if piece.expanded:
            offset = begin
        if offset != self._last_error:
            self._errors += 1
            if begin not in self._unit.flawed:
                self._report(diagnostic)
        self._last_error = offset
        if self._errors == MAX_ERRORS:
            span = self._unit.span(offset, offset + 1)
            self._report(
                syntax.TOO_MANY.at(
                    span, f"{MAX_ERRORS} syntax errors: the rest is not read"
                )
            )
            self._parser.position = len(self._text)
            self._errors += 1

    def _unexpected(self, token: Token) -> None:
        if token.type == END and self._unit.cut:
            self._close()
            return
        from rtgen.compiler.frontends.idl.syntax.syntax_errors import (
            ErrorContext,
            explain,
        )

        accepted = self._parser.accepts()
        if "ERROR" in accepted:  # between declarations, where another `;` is an error
            accepted.discard("SEMI")
        start = token.start_pos
        context = ErrorContext(
            unit=self._unit,
            kind=token.type,
            text=str(token),
            start=start,
            end=max(token.end_pos, start + 1),
            accepted=accepted,
            last=len(self._text[:start].rstrip()),
            opening=self._parser.opening(),
            surplus=self._surplus,
        )
        recovery = explain(context)
        after_last = recovery.feed and not recovery.instead
        if recovery.diagnostic is not None:
            self._emit(recovery.diagnostic, context.last if after_last else start)
        if not self._recover(recovery, context):
            self._resume(start, context.statement)

    def _recover(self, recovery: Recovery, context: ErrorContext) -> bool:
        """Apply a recovery and continue; False if impossible, or already tried here."""
        again = (context.start, recovery.feed, recovery.resume)
        if self._errors > MAX_ERRORS or again in self._mended:
            return False
        self._mended.add(again)
        parser = self._parser
        if recovery.instead and not recovery.feed:
            self._surplus -= {"{": 1, "}": -1}.get(context.text, 0)
            parser.position = context.end
            return True
        if not recovery.feed and recovery.resume is None:
            return False
        if recovery.back or not recovery.feed:
            self._parser.unwind()
            if not recovery.feed:
                self._lose(context.statement, recovery.resume or context.start)
                parser.feed(token("ERROR", context.start))
        place = context.start if recovery.instead else context.last
        for terminal in recovery.feed:
            if terminal not in parser.accepts():
                return False
            text = WORDS.get(terminal, terminal.lower())
            supplied = token(
                terminal, place, f"_{context.text}" if terminal == "IDENT" else text
            )
            if recovery.instead:
                supplied.end_pos = context.end
            parser.feed(supplied)
            self._surplus += {"LBRACE": 1, "RBRACE": -1}.get(terminal, 0)
        if recovery.instead:
            parser.position = context.end
        elif recovery.resume is not None:
            parser.position = recovery.resume
        return True

    def _close(self) -> None:
        most = min(3 * len(self._parser.states), MAX_CLOSING_TOKENS)
        self._parser.close(len(self._text), most)

    def _lose(self, start: int, end: int) -> None:
        """Record the names that an invalid declaration may have declared."""
        names = [match[1] for match in _DECLARED.finditer(self._text, start, end)]
        for match in _ENUMERATORS.finditer(self._text, start, end):
            names += _NAME.findall(match[1])
        self._unit.maybe_declared.update(
            name.removeprefix("_").lower() for name in names if name not in RESERVED
        )

    def _bad_character(self) -> None:
        from rtgen.compiler.frontends.idl.syntax.syntax_errors import (
            bad_character,
            is_blank,
            meant,
        )

        parser = self._parser
        start = parser.position
        text = self._text
        if text[start] == '"' or text.startswith('L"', start):
            self._open_string(start)
        elif is_blank(text[start]):
            if text[start] not in self._blanks:
                self._emit(bad_character(self._unit, text, start), start)
            self._blanks.add(text[start])
            parser.position = start + 1
        else:
            self._emit(bad_character(self._unit, text, start), start)
            terminal, length = meant(text, start)
            if terminal is not None and terminal in parser.accepts():
                parser.position = start + length
                parser.feed(token(terminal, start, text[start : start + length]))
            else:
                statement = max(text.rfind(mark, 0, start) for mark in ";{}") + 1
                self._resume(start, statement)
        if self._errors > MAX_ERRORS:
            parser.position = len(text)

    def _open_string(self, start: int) -> None:
        """End an unterminated string at its line, before a `;` there."""
        text = self._text
        line_end = text.find("\n", start)
        line = text[start : len(text) if line_end < 0 else line_end].rstrip()
        end = start + len(line) - line.endswith(";")
        span = self._unit.span(start, max(end, start + 1))
        hint = 'put " at its end'
        self._emit(
            syntax.UNCLOSED_TEXT.at(span, "this string is never closed", hint=hint),
            start,
        )
        self._parser.position = end
        if "STRING" in self._parser.accepts():
            closed = 'L""' if text[start] == "L" else '""'
            self._parser.feed(token("STRING", start, closed))

    def _resume(self, start: int, statement: int) -> None:
        """Reset the stack to a list of declarations, and skip the rest of the invalid one."""
        depth = self._parser.unwind()
        self._parser.feed(token("ERROR", start))
        if self._errors > MAX_ERRORS:
            start = len(self._text)
        position = self._parser.resumption(start, depth, _MARKS)
        self._lose(statement, position)
        self._parser.position = position
        if position >= len(self._text):
            self._close()


def _mark_closers(text: str) -> str:
    """Mark each `>>` that closes two templates, so that the lexer does not read it as a shift.

    It is a shift if enough `>` follow in the declaration to close all open templates.
    """
    tokens = [(match[0], match.start()) for match in _TEMPLATES.finditer(text)]
    lowest = _lowest(tokens)
    closers = []
    open_templates = 0
    previous = ""
    for index, (mark, offset) in enumerate(tokens):
        if mark == "<" and previous in _TEMPLATE_WORDS:
            open_templates += 1
        elif mark == ">":
            open_templates = max(open_templates - 1, 0)
        elif mark in (";", "{", "}"):
            open_templates = 0
        elif (
            mark == ">>" and open_templates >= 2 and open_templates + lowest[index] > 0
        ):
            closers.append(offset)
            open_templates -= 2
        previous = mark
    parts: list[str] = []
    start = 0
    for offset in closers:
        parts += text[start:offset], _CLOSER, ">"
        start = offset + 2
    parts.append(text[start:])
    return "".join(parts)


def _lowest(tokens: list[tuple[str, int]]) -> list[int]:
    """Return for each token the least number of open templates in the rest of the declaration."""
    lowest = [0] * len(tokens)
    low = 0
    for index in range(len(tokens) - 1, -1, -1):
        lowest[index] = low
        mark = tokens[index][0]
        low = 0 if mark in (";", "{", "}") else min(_OPENED.get(mark, 0) + low, 0)
    return lowest
