"""Text to syntax tree: an LALR(1) parser, and recovery so that one mistake hides no other.

After a mistake the parser's stack goes back to the innermost list of declarations, the text is
passed over to the end of the broken declaration, and parsing goes on behind it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from rtgen.diagnostics import Diagnostic
from rtgen.frontends import lalr
from rtgen.frontends.idl import mistakes, tree
from rtgen.frontends.idl.builder import Builder
from rtgen.frontends.idl.rules import syntax
from rtgen.frontends.idl.unit import Unit
from rtgen.frontends.idl.words import RESERVED
from rtgen.frontends.lalr import END, Token, token

MAX_ERRORS = 50
"""After so many syntax errors in one file the rest of it is not read."""

MOST_CLOSED = 200
"""At the end of a broken text so many marks at most are supplied to close what is open: each one
costs a copy of the parser's stack."""

_MARKS = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n]){0,12}\'|[{};]', re.DOTALL)
_TEMPLATES = re.compile(
    r"""L?"(?:\\.|[^"\\\n])*"|L?'(?:\\.|[^'\\\n]){0,12}'|>>|<<|[<>;{}]|[^\s<>;{}"'\w]+|\w+""",
    re.DOTALL,
)
_END_OF_DECLARATION = re.compile(r"\s*;|[ \t]*\w+\s*;")
_TEMPLATE_WORDS = frozenset(
    ("sequence", "string", "wstring", "fixed", "map", "bitfield")
)
_CLOSER = "\x01"


@cache
def _grammar() -> lalr.Grammar:
    return lalr.load("idl", Builder(), RESERVED)


def parse(unit: Unit, report: Callable[[Diagnostic], None]) -> tuple[tree.Item, ...]:
    """The declarations of a unit, without those that have a syntax error; never raises."""
    return _Run(unit, report).result()


class _Run:
    def __init__(self, unit: Unit, report: Callable[[Diagnostic], None]) -> None:
        self._unit = unit
        self._report = report
        self._text = _mark_closers(unit.text) if ">>" in unit.text else unit.text
        self._parser = lalr.Parser(_grammar(), self._text)
        self._errors = 0
        self._last_error = -1

    def result(self) -> tuple[tree.Item, ...]:
        while True:
            try:
                items: tuple[tree.Item, ...] = self._parser.run()
                return items
            except lalr.UnexpectedTokenError as error:
                self._unexpected(error.token)
            except lalr.UnexpectedCharacterError:
                self._bad_character()

    def _emit(self, diagnostic: Diagnostic, offset: int) -> None:
        """Report it, unless a mistake at the very same place is reported already."""
        if offset != self._last_error:
            self._errors += 1
            if self._unit.piece(offset)[1] not in self._unit.flawed:
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

    def _unexpected(self, found: Token) -> None:
        parser = self._parser
        accepted = parser.accepts()
        if (
            "ERROR" in accepted
        ):  # between declarations, where a `;` would be one too many
            accepted.discard("SEMI")
        last = len(self._text[: found.start_pos].rstrip())
        opening = self._opening()
        mistake = mistakes.explain(self._unit, found, accepted, last, opening)
        if mistake is not None:
            start = found.start_pos
            self._emit(mistake.diagnostic, last if mistake.semicolon else start)
            if mistake.semicolon:
                parser.feed(token("SEMI", last, ";"))
                parser.position = start
                return
        self._resume(found)

    def _opening(self) -> int | None:
        """The place of the innermost brace that is open."""
        for value in reversed(self._parser.values):
            if getattr(value, "type", None) == "LBRACE":
                place: int = value.start_pos
                return place
        return None

    def _bad_character(self) -> None:
        start = self._parser.position
        text = self._text
        if text[start] == '"' or text.startswith('L"', start):
            line_end = text.find("\n", start)
            line = text[start : len(text) if line_end < 0 else line_end].rstrip()
            end = start + len(line) - line.endswith(";")
            span = self._unit.span(start, max(end, start + 1))
            self._emit(
                syntax.UNCLOSED_TEXT.at(span, "this string is never closed"), start
            )
            self._parser.position = end
            if "STRING" in self._parser.accepts():
                self._parser.feed(token("STRING", start, '""'))
                return
        else:
            self._emit(mistakes.bad_character(self._unit, text, start), start)
            meant, length = mistakes.meant(text, start)
            self._parser.position = start + length
            if meant is not None and meant in self._parser.accepts():
                self._parser.feed(token(meant, start, text[start : start + length]))
                return
        if self._errors > MAX_ERRORS:
            self._parser.position = len(text)

    def _resume(self, found: Token) -> None:
        """Go back to a list of declarations and pass over the rest of the broken one."""
        start = found.start_pos
        depth = self._unwind()
        self._parser.feed(token("ERROR", start))
        if self._errors > MAX_ERRORS:
            start = len(self._text)
        position = self._behind(start, depth)
        stuck = position == start < len(self._text)
        if stuck and "RBRACE" not in self._parser.accepts():
            rest = _END_OF_DECLARATION.match(self._text, start + 1)
            position = rest.end() if rest else start + 1
        self._parser.position = position
        if position >= len(self._text):
            self._close()

    def _behind(self, start: int, depth: int) -> int:
        """Behind the `;` that ends the declaration, or before the `}` around it."""
        opened = depth > 0
        for match in _MARKS.finditer(self._text, start):
            mark = match[0]
            if mark == "{":
                depth += 1
                opened = True
            elif mark == "}":
                if depth == 0:
                    return match.start()
                depth -= 1
                if depth == 0 and opened:
                    rest = _END_OF_DECLARATION.match(self._text, match.end())
                    return rest.end() if rest else match.end()
            elif mark == ";" and depth == 0:
                return match.end()
        return len(self._text)

    def _unwind(self) -> int:
        """Go back to the innermost list of declarations, and say how many braces were open."""
        parser = self._parser
        depth = 0
        while len(parser.states) > 1 and (depth < 0 or not parser.takes("ERROR")):
            parser.states.pop()
            kind = getattr(parser.values.pop(), "type", None)
            depth += (kind == "LBRACE") - (kind == "RBRACE")
        return depth

    def _close(self) -> None:
        """Close what is open at the end of the text, to keep what was read before."""
        end = len(self._text)
        parser = self._parser
        for _ in range(min(3 * len(parser.states), MOST_CLOSED)):
            accepted = parser.accepts()
            if END in accepted:
                return
            if "RBRACE" in accepted:
                parser.feed(token("RBRACE", end, "}"))
            elif "SEMI" in accepted:
                parser.feed(token("SEMI", end, ";"))
            else:
                self._unwind()
                parser.feed(token("ERROR", end))
        del parser.states[1:], parser.values[:]


def _mark_closers(text: str) -> str:
    """Mark each `>>` that closes two templates, so that the lexer tells it from a shift.

    It is a shift if, without it, enough `>` follow in the declaration to close what is open.
    """
    tokens = [(match[0], match.start()) for match in _TEMPLATES.finditer(text)]
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
            mark == ">>"
            and open_templates >= 2
            and not _closed(tokens, index, open_templates)
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


def _closed(tokens: list[tuple[str, int]], index: int, needed: int) -> bool:
    """Whether the tokens behind `index` close that many templates without it."""
    for mark, _ in tokens[index + 1 : index + 1000]:
        if mark in (";", "{", "}"):
            break
        needed += (mark == "<") - mark.count(">") * (mark in (">", ">>"))
        if needed <= 0:
            return True
    return False
