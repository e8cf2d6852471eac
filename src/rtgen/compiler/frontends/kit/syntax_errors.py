"""Context of a syntax error: the unexpected token, its surroundings, how to recover from it."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Set
from dataclasses import dataclass
from functools import cached_property

from rtgen.compiler.diagnostics import Diagnostic, Related, Rule, Span

MAX_CONTEXT = 4000
"""Number of characters around an error that are examined."""

ENDS = re.compile(r"[;{}]")
"""Characters that end declarations."""

_MAX_SHOWN = 6
_INTERNAL = frozenset(("ERROR", "ANNOTATION_DCL", "TRAILING"))


@dataclass(frozen=True, slots=True)
class Recovery:
    """A diagnostic with a recovery; without a diagnostic, the error has been reported.

    `feed` are terminals to supply before the token, or instead of it with `instead` (without
    `feed`, the token is dropped), after unwinding to the list of declarations with `back`. `resume`
    is the offset where parsing resumes; None: after the broken declaration.
    """

    diagnostic: Diagnostic | None
    feed: tuple[str, ...] = ()
    instead: bool = False
    back: bool = False
    resume: int | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class BaseContext(ABC):
    """An unexpected token and its surroundings, in a language with braces and `;`.

    `kind` is the token's terminal; `accepted` are the allowed terminals; `last` is the end of the
    previous token; `opening` is the innermost open brace; `surplus` is the number of `{` minus that
    of `}` in the text.
    """

    kind: str
    text: str
    start: int
    end: int
    accepted: Set[str]
    last: int
    opening: int | None
    surplus: int

    @property
    @abstractmethod
    def code(self) -> str:
        """The parsed text."""

    @abstractmethod
    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of the text."""

    @abstractmethod
    def span_after(self, offset: int) -> Span:
        """Return the place directly after the character before an offset."""

    @staticmethod
    @abstractmethod
    def shown(terminal: str) -> str:
        """Return a terminal as shown in messages: `a name`, `';'`."""

    @cached_property
    def statement(self) -> int:
        """The start of the declaration that contains the token."""
        begin = low = max(0, self.start - MAX_CONTEXT)
        for match in ENDS.finditer(self.code, low, self.start):
            begin = match.end()
        return begin

    @property
    def fresh_line(self) -> bool:
        """Whether the token starts a line."""
        return "\n" in self.code[self.last : self.start]

    def recovery(
        self,
        rule: Rule,
        message: str,
        hint: str | None = None,
        *,
        at: tuple[int, int] | None = None,
        after_last: bool = False,
        related: Iterable[Related] = (),
        feed: tuple[str, ...] = (),
        instead: bool = False,
        back: bool = False,
        resume: int | None = None,
    ) -> Recovery:
        """Return a recovery with a diagnostic at the token, at `at`, or `after_last` token."""
        start, end = at or (self.start, self.end)
        span = self.span_after(self.last) if after_last else self.span(start, end)
        diagnostic = rule.at(span, message, related=related, hint=hint)
        return Recovery(diagnostic, feed, instead, back, resume)

    def expectation(self) -> str:
        """Return `: a name or ';' was expected`, if that is short."""
        names = sorted({self.shown(terminal) for terminal in self.accepted - _INTERNAL})
        if not names or len(names) > _MAX_SHOWN:
            return ""
        if len(names) == 1:
            return f": {names[0]} was expected"
        return f": {', '.join(names[:-1])} or {names[-1]} was expected"
