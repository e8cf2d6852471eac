"""Text to syntax tree: lark's LALR parser, and recovery so that one mistake hides no other.

After a mistake the parser's stack goes back to the innermost list of declarations, the text is
passed over to the end of the broken declaration, and parsing goes on behind it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from rtgen.diagnostics import Diagnostic
from rtgen.frontends.idl import mistakes, tree
from rtgen.frontends.idl.builder import Builder
from rtgen.frontends.idl.rules import syntax
from rtgen.frontends.idl.unit import Unit
from rtgen.frontends.idl.words import RESERVED, TERMINALS
from rtgen.resources import grammar

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedInput

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


class _AlwaysNames:
    """Lets the contextual lexer see an identifier in every state, so `structure` is no `struct`."""

    always_accept = ("IDENT",)

    @staticmethod
    def process(stream: Any) -> Any:
        return stream


def _reserve(token: Token) -> Token:
    """An identifier that is a reserved word is that word's terminal, whatever the state."""
    if token in RESERVED:
        token.type = TERMINALS[token]
    return token


@cache
def _parser() -> Lark:
    from lark import Lark

    return Lark(
        grammar("idl.lark"),
        parser="lalr",
        lexer="contextual",
        start="specification",
        transformer=Builder(),
        postlex=_AlwaysNames(),
        lexer_callbacks={"IDENT": _reserve},
        maybe_placeholders=False,
    )


def parse(unit: Unit, report: Callable[[Diagnostic], None]) -> tuple[tree.Item, ...]:
    """The declarations of a unit, without those that have a syntax error; never raises."""
    return _Run(unit, report).result()


class _Run:
    def __init__(self, unit: Unit, report: Callable[[Diagnostic], None]) -> None:
        self._unit = unit
        self._report = report
        self._text = _mark_closers(unit.text) if ">>" in unit.text else unit.text
        self._parser: Any = _parser().parse_interactive(
            self._text
        )  # lark leaves it untyped
        self._errors = 0
        self._last_error = -1

    def result(self) -> tuple[tree.Item, ...]:
        from lark.exceptions import UnexpectedCharacters, UnexpectedToken

        while True:
            try:
                state = self._parser.parser_state
                feed = state.feed_token
                for token in self._parser.lexer_thread.lex(state):
                    feed(token)
                items: tuple[tree.Item, ...] = self._finish()
                return items
            except UnexpectedToken as error:
                self._unexpected(error.token, error)
            except UnexpectedCharacters as error:
                self._bad_character(error)

    def _finish(self) -> tuple[tree.Item, ...]:
        end = self._token("$END", len(self._text))
        result: tuple[tree.Item, ...] = self._parser.parser_state.feed_token(end, True)
        return result

    def _token(self, type_: str, start: int, value: str = "") -> Token:
        from lark import Token

        return Token(type_, value, start_pos=start, end_pos=start + len(value))

    @property
    def _position(self) -> int:
        place: int = self._parser.lexer_thread.state.line_ctr.char_pos
        return place

    @_position.setter
    def _position(self, offset: int) -> None:
        self._parser.lexer_thread.state.line_ctr.char_pos = offset

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
            self._position = len(self._text)
            self._errors += 1

    def _unexpected(self, token: Token, error: UnexpectedInput) -> None:
        state = self._parser
        accepted = set(state.accepts())
        if (
            "ERROR" in accepted
        ):  # between declarations, where a `;` would be one too many
            accepted.discard("SEMI")
        last = self._last_end(token)
        opening = self._opening()
        mistake = mistakes.explain(self._unit, token, accepted, last, opening)
        if mistake is not None:
            self._emit(
                mistake.diagnostic, last if mistake.semicolon else token.start_pos or 0
            )
            if mistake.semicolon:
                state.feed_token(self._token("SEMI", last, ";"))
                self._position = token.start_pos or 0
                if token.type == "$END":
                    self._position = len(self._text)
                return
        self._resume(token)

    def _last_end(self, token: Token) -> int:
        """Where the token before the unexpected one ends."""
        start = token.start_pos if token.start_pos is not None else len(self._text)
        if token.type == "$END":
            start = len(self._text)
        return len(self._text[:start].rstrip())

    def _opening(self) -> int | None:
        """The place of the innermost brace that is open."""
        for value in reversed(self._parser.parser_state.value_stack):
            if getattr(value, "type", None) == "LBRACE":
                place: int = value.start_pos
                return place
        return None

    def _bad_character(self, error: UnexpectedInput) -> None:
        start = self._position
        text = self._text
        if text[start] == '"' or text.startswith('L"', start):
            line_end = text.find("\n", start)
            line = text[start : len(text) if line_end < 0 else line_end].rstrip()
            end = start + len(line) - line.endswith(";")
            span = self._unit.span(start, max(end, start + 1))
            self._emit(
                syntax.UNCLOSED_TEXT.at(span, "this string is never closed"), start
            )
            self._position = end
            if "STRING" in self._parser.accepts():
                self._parser.feed_token(self._token("STRING", start, '""'))
                return
        else:
            self._emit(mistakes.bad_character(self._unit, text, start), start)
            meant, length = mistakes.meant(text, start)
            self._position = start + length
            if meant is not None and meant in self._parser.accepts():
                self._parser.feed_token(
                    self._token(meant, start, text[start : start + length])
                )
                return
        if self._errors > MAX_ERRORS:
            self._position = len(text)

    def _resume(self, token: Token) -> None:
        """Go back to a list of declarations and pass over the rest of the broken one."""
        state = self._parser.parser_state
        start = len(self._text) if token.type == "$END" else token.start_pos or 0
        depth = self._unwind()
        state.feed_token(self._token("ERROR", start))
        if self._errors > MAX_ERRORS:
            start = len(self._text)
        position = self._behind(start, depth)
        stuck = position == start < len(self._text)
        if stuck and "RBRACE" not in self._parser.accepts():
            rest = _END_OF_DECLARATION.match(self._text, start + 1)
            position = rest.end() if rest else start + 1
        self._position = position
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
        state = self._parser.parser_state
        states = state.parse_conf.states
        depth = 0
        while len(state.state_stack) > 1 and (
            depth < 0 or "ERROR" not in states[state.position]
        ):
            state.state_stack.pop()
            kind = getattr(state.value_stack.pop(), "type", None)
            depth += (kind == "LBRACE") - (kind == "RBRACE")
        return depth

    def _close(self) -> None:
        """Close what is open at the end of the text, to keep what was read before."""
        end = len(self._text)
        state = self._parser.parser_state
        for _ in range(min(3 * len(state.state_stack), MOST_CLOSED)):
            accepted = self._parser.accepts()
            if "$END" in accepted:
                return
            if "RBRACE" in accepted:
                state.feed_token(self._token("RBRACE", end, "}"))
            elif "SEMI" in accepted:
                state.feed_token(self._token("SEMI", end, ";"))
            else:
                self._unwind()
                state.feed_token(self._token("ERROR", end))
        del state.state_stack[1:], state.value_stack[:]


def _mark_closers(text: str) -> str:
    """Mark each `>>` that closes two templates, so that the lexer tells it from a shift.

    It is a shift if, without it, enough `>` follow in the declaration to close what is open.
    """
    tokens = [(match[0], match.start()) for match in _TEMPLATES.finditer(text)]
    closers = []
    open_templates = 0
    previous = ""
    for index, (token, offset) in enumerate(tokens):
        if token == "<" and previous in _TEMPLATE_WORDS:
            open_templates += 1
        elif token == ">":
            open_templates = max(open_templates - 1, 0)
        elif token in (";", "{", "}"):
            open_templates = 0
        elif (
            token == ">>"
            and open_templates >= 2
            and not _closed(tokens, index, open_templates)
        ):
            closers.append(offset)
            open_templates -= 2
        previous = token
    parts: list[str] = []
    start = 0
    for offset in closers:
        parts += text[start:offset], _CLOSER, ">"
        start = offset + 2
    parts.append(text[start:])
    return "".join(parts)


def _closed(tokens: list[tuple[str, int]], index: int, needed: int) -> bool:
    """Whether the tokens behind `index` close that many templates without it."""
    for token, _ in tokens[index + 1 : index + 1000]:
        if token in (";", "{", "}"):
            break
        needed += (token == "<") - token.count(">") * (token in (">", ">>"))
        if needed <= 0:
            return True
    return False
