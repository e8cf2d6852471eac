"""Text to syntax tree: an LALR(1) parser with error recovery.

The parser distinguishes typedef names from identifiers, so typedefs are recorded, and imports
read, as soon as their statement ends. After a syntax error the parser's stack is unwound to the
innermost list of statements, the rest of the broken statement is skipped, and parsing resumes.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Protocol

from rtgen.compiler.diagnostics import Diagnostic, Severity
from rtgen.compiler.frontends.cdl.rules import syntax
from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.builder import Builder, Head
from rtgen.compiler.frontends.cdl.syntax.keywords import (
    RESERVED,
    SPECIFIERS,
    TERMINALS,
    WORDS,
)
from rtgen.compiler.frontends.cdl.syntax.unit import TypeNames, Unit
from rtgen.compiler.frontends.kit import lalr
from rtgen.compiler.frontends.kit.grammars import load
from rtgen.compiler.frontends.kit.lalr import END, WORD, Token, token
from rtgen.compiler.frontends.kit.recovery import RecoveringParser
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.compiler.model.types import ScopedName

if TYPE_CHECKING:
    from rtgen.compiler.frontends.cdl.syntax.syntax_errors import ErrorContext
    from rtgen.compiler.frontends.kit.syntax_errors import Recovery

MAX_ERRORS = 50
"""After this many syntax errors the rest of a file is skipped."""

_MARKS = re.compile(r'"(?:[^"\\\n]|\\.)*"|[{};]', re.DOTALL)
_DECLARED = re.compile(r"\b([A-Za-z_]\w*)(?=\s*[;,{(\[=}])")


class Imports(Protocol):
    """Interface to the reader of a unit's imports."""

    @property
    def lacks_types(self) -> bool:
        """Whether a missing file may declare types."""

    def import_file(self, statement: statements.Import, unit: Unit) -> None:
        """Read an imported CDL file."""

    def import_header(self, statement: statements.ImportC, unit: Unit) -> None:
        """Read a C header."""


@cache
def _grammar() -> lalr.Grammar:
    return load("cdl", Builder(), RESERVED)


def parse(
    unit: Unit,
    types: TypeNames,
    imports: Imports,
    report: Callable[[Diagnostic], None],
) -> tuple[statements.Item, ...]:
    """Return the statements of a unit, without those that have a syntax error; never raises."""
    return _Run(unit, types, imports, report).result()


class CdlParser(RecoveringParser):
    """A parser that tracks typedef names and specifier lists."""

    watched = frozenset(("SEMI", "LBRACE", "SPEC_L", "SPEC_R"))
    judges_all_words = True
    most = MAX_NESTING

    def __init__(self, unit: Unit, types: TypeNames, imports: Imports) -> None:
        super().__init__(_grammar(), unit.source.code)
        self.space: ScopedName = ()
        self._unit = unit
        self._types = types
        self._imports = imports
        self._in_specifiers = False

    def word(self, text: str, end: int) -> str:
        if text in self._types.declared and self._types.knows(self.space, text):
            return "TYPE_NAME"
        if self._in_specifiers and text in SPECIFIERS:
            return TERMINALS[text]
        if text in self._types.prelude and self.takes("TYPE_NAME"):
            # In a cast or in parentheses, a name of the prelude denotes a type.
            return "TYPE_NAME" if self.would_shift("TYPE_NAME") else WORD
        return WORD

    def other(self, token: Token) -> Token:
        kind = {"LBRACK": "SPEC_L", "RBRACK": "SPEC_R"}.get(token.type)
        if kind is not None and self.takes(kind):
            token.type = kind
            return token
        return self.refused(token)

    def refused(self, token: Token) -> Token:
        """Raise the error for a token that is invalid in every interpretation."""
        self.position = token.start_pos
        if token.type == "UNKNOWN":
            raise lalr.UnexpectedCharacterError
        raise lalr.UnexpectedTokenError(token)

    def shifted(self, token: Token) -> None:
        kind = token.type
        if kind == "SEMI":
            self._ended(self.values[-2])
        elif kind == "LBRACE":
            if isinstance(self.values[-2], Head):
                self.space = (*self.space, self.values[-2].name.text)
        else:
            self._in_specifiers = kind == "SPEC_L"

    def _ended(self, statement: object) -> None:
        """Apply the effect of a statement on later tokens: typedefs, imports, scopes."""
        if isinstance(statement, tree.Typedef):
            for declarator in statement.declarators:
                if declarator.name is not None:
                    self._types.declare(self.space, declarator.name.text)
        elif isinstance(statement, statements.Namespace):
            self.space = self.space[:-1]
        elif isinstance(statement, statements.Import):
            self._imports.import_file(statement, self._unit)
        elif isinstance(statement, statements.ImportC):
            self._imports.import_header(statement, self._unit)

    def unwind(self) -> int:
        depth = super().unwind()
        self._in_specifiers = False
        self.space = tuple(
            head.name.text
            for head, brace in zip(self.values, self.values[1:], strict=False)
            if isinstance(head, Head) and getattr(brace, "type", None) == "LBRACE"
        )
        return depth


class _Run:
    def __init__(
        self,
        unit: Unit,
        types: TypeNames,
        imports: Imports,
        report: Callable[[Diagnostic], None],
    ) -> None:
        self._unit = unit
        self._report = report
        self._text = unit.source.code
        self._types = types
        self._imports = imports
        self._parser = CdlParser(unit, types, imports)
        self._errors = 0
        self._last_error = -1
        self._surplus = self._text.count("{") - self._text.count("}")
        self._mended: set[tuple[int, tuple[str, ...], int | None]] = set()

    def result(self) -> tuple[statements.Item, ...]:
        while True:
            try:
                items: tuple[statements.Item, ...] = self._parser.run()
                return items
            except lalr.UnexpectedTokenError as error:
                self._unexpected(error.token)
            except lalr.UnexpectedCharacterError:
                self._bad_character()
            except lalr.TooDeepError as error:
                self._too_deep(error.token)

    def _emit(self, diagnostic: Diagnostic, offset: int) -> None:
        """Report an error unless one at the same position is already reported."""
        if offset != self._last_error:
            self._errors += diagnostic.severity is Severity.ERROR
            self._report(diagnostic)
        self._last_error = offset
        if self._errors == MAX_ERRORS:
            span = self._unit.span(offset, offset + 1)
            message = f"{MAX_ERRORS} syntax errors: the rest is not read"
            self._report(syntax.TOO_MANY.at(span, message))
            self._errors += 1

    def _unexpected(self, token: Token) -> None:
        if token.type == END and self._unit.source.unfinished:
            self._parser.close(len(self._text), 3 * MAX_NESTING)
            return
        from rtgen.compiler.frontends.cdl.syntax.syntax_errors import (
            ErrorContext,
            explain,
        )

        start = token.start_pos
        context = ErrorContext(
            unit=self._unit,
            types=self._types,
            lacks_types=self._imports.lacks_types,
            kind=token.type,
            text=str(token),
            start=start,
            end=max(token.end_pos, start + 1),
            accepted=self._parser.accepts(),
            last=len(self._text[:start].rstrip()),
            opening=self._parser.opening(),
            surplus=self._surplus,
        )
        recovery = explain(context)
        if recovery.diagnostic is not None:
            after_last = recovery.feed and not recovery.instead
            self._emit(recovery.diagnostic, context.last if after_last else start)
        if not self._recover(recovery, context):
            self._resume(start)

    def _recover(self, recovery: Recovery, context: ErrorContext) -> bool:
        """Apply the repair of an error; False if impossible, or already tried at this position."""
        again = (context.start, recovery.feed, recovery.resume)
        if self._errors > MAX_ERRORS or again in self._mended:
            return False
        self._mended.add(again)
        parser = self._parser
        if recovery.instead and not recovery.feed:
            self._surplus -= {"{": 1, "}": -1}.get(context.text, 0)
            parser.position = recovery.resume or context.end
            return True
        if not recovery.feed:
            return False
        place = context.start if recovery.instead else context.last
        for terminal in recovery.feed:
            if terminal not in parser.accepts():
                return False
            text = context.text if recovery.instead else WORDS.get(terminal, "")
            supplied = token(terminal, place, text)
            if not recovery.instead:
                supplied.end_pos = place
            parser.feed(supplied)
            self._surplus += {"LBRACE": 1, "RBRACE": -1}.get(terminal, 0)
        if recovery.instead:
            parser.position = context.end
        elif recovery.resume is not None:
            parser.position = recovery.resume
        else:
            parser.position = context.start
        return True

    def _bad_character(self) -> None:
        from rtgen.compiler.frontends.cdl.syntax.syntax_errors import (
            bad_character,
            meant,
        )

        parser = self._parser
        start = parser.position
        diagnostic, resume = bad_character(self._unit, start)
        self._emit(diagnostic, start)
        if self._text[start] == '"':
            parser.position = resume
            if "STRING" in parser.accepts():
                parser.feed(token("STRING", start, '""'))
            return
        terminal = meant(self._text[start:resume])
        if self._errors > MAX_ERRORS:
            self._resume(start)
        elif terminal is None:
            parser.position = resume
        elif terminal in parser.accepts():
            parser.position = resume
            parser.feed(token(terminal, start, self._text[start:resume]))
        else:
            self._resume(start)

    def _too_deep(self, token: Token) -> None:
        start = token.start_pos
        message = "this is nested too deeply to be read"
        span = self._unit.span(start, max(token.end_pos, start + 1))
        self._emit(syntax.TOO_DEEP.at(span, message), start)
        depth = self._parser.unwind()
        while len(self._parser.states) > MAX_NESTING // 2:
            self._parser.states.pop()
            self._parser.values.pop()
            depth += self._parser.unwind()
        self._resume(start, depth)

    def _resume(self, start: int, depth: int = 0) -> None:
        """Unwind to a list of statements and skip the rest of the broken one."""
        depth += self._parser.unwind()
        self._parser.feed(token("ERROR", start))
        if self._errors > MAX_ERRORS:
            start = len(self._text)
        position = self._parser.resumption(start, depth, _MARKS)
        statement = max(self._text.rfind(mark, 0, start) for mark in ";{}") + 1
        names = _DECLARED.findall(self._text, statement, position)
        self._unit.skipped = True
        self._unit.maybe_declared.update(names)
        self._parser.position = position
        if position >= len(self._text):
            self._parser.close(len(self._text), 3 * MAX_NESTING)
