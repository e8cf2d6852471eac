"""Context of a syntax error: the unexpected token and its surroundings."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from rtgen.compiler.diagnostics import Related, Rule, Span
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED, shown
from rtgen.compiler.frontends.idl.text.unit import Unit
from rtgen.compiler.frontends.kit.syntax_errors import (
    ENDS,
    MAX_CONTEXT,
    BaseContext,
    Recovery,
)

_WORD = re.compile(
    r"\"(?:\\.|[^\"\\\n])*\"?|'(?:\\.|[^'\\\n]){0,12}'?|::|<<|>>|\w+|[^\s\w]"
)
_AHEAD = 24

DEFINERS = (
    *("struct", "union", "enum", "exception", "interface", "module", "valuetype"),
    *("bitset", "bitmask", "component", "home", "eventtype", "porttype", "connector"),
)
"""Keywords that determine the kind of a body."""


@dataclass(frozen=True, slots=True)
class Word:
    """A token of the text at [start, end)."""

    text: str
    start: int
    end: int

    @property
    def is_name(self) -> bool:
        """Whether it is an identifier, not a keyword."""
        return self.is_word and self.text not in RESERVED

    @property
    def is_word(self) -> bool:
        """Whether it is an identifier or a keyword."""
        return self.text[0].isalpha() or self.text[0] == "_"


@dataclass(frozen=True, eq=False, kw_only=True)
class ErrorContext(BaseContext):
    """An unexpected token of IDL and its surroundings."""

    unit: Unit

    @property
    def code(self) -> str:
        return self.unit.text

    def span(self, start: int, end: int) -> Span:
        return self.unit.span(start, end)

    def span_after(self, offset: int) -> Span:
        return self.unit.after(offset)

    @staticmethod
    def shown(terminal: str) -> str:
        return shown(terminal)

    @cached_property
    def before(self) -> list[Word]:
        """The tokens of the declaration before the unexpected one."""
        return words(self.unit.text, self.statement, self.last)

    @cached_property
    def after(self) -> list[Word]:
        """Some tokens after the unexpected one."""
        return words(self.unit.text, self.end, self.end + MAX_CONTEXT, _AHEAD)

    @cached_property
    def header(self) -> list[Word]:
        """The tokens before the innermost open brace: `struct S`, `interface I : A`."""
        if self.opening is None:
            return []
        return header(self.unit.text, self.opening)

    @cached_property
    def construct(self) -> str:
        """The construct of the innermost open brace; empty at file scope."""
        return next((w.text for w in self.header if w.text in DEFINERS), "")

    @property
    def called(self) -> str:
        """The construct with its name: `struct S`."""
        definers = [i for i, w in enumerate(self.header) if w.text in DEFINERS]
        rest = self.header[definers[0] : definers[0] + 2] if definers else []
        return " ".join(w.text for w in rest)

    @property
    def first(self) -> str:
        """The first word of the declaration; empty if the token is the first."""
        return self.before[0].text if self.before else ""

    @property
    def previous(self) -> str:
        """The text of the token before."""
        return self.before[-1].text if self.before else ""

    @property
    def following(self) -> str:
        """The text of the token after."""
        return self.after[0].text if self.after else ""

    @property
    def in_parameters(self) -> bool:
        """Whether a parenthesis is open."""
        texts = [word.text for word in self.before]
        return texts.count("(") > texts.count(")")

    def recover(
        self,
        rule: Rule,
        message: str,
        hint: str | None,
        *,
        at: Word | tuple[int, int] | None = None,
        after_last: bool = False,
        related: Iterable[Related] = (),
        feed: tuple[str, ...] = (),
        instead: bool = False,
        back: bool = False,
        resume: int | None = None,
    ) -> Recovery:
        """Return a recovery as `recovery` does, also at a word."""
        return self.recovery(
            rule,
            message,
            hint,
            at=(at.start, at.end) if isinstance(at, Word) else at,
            after_last=after_last,
            related=related,
            feed=feed,
            instead=instead,
            back=back,
            resume=resume,
        )

    def missing(
        self,
        mark: str,
        hint: str,
        *,
        feed: str | None = None,
        resume: int | None = None,
    ) -> Recovery:
        """Recognize a token missing after the previous one; parsing continues with it supplied."""
        return self.recover(
            syntax.MISSING_MARK,
            f"a '{mark}' is missing here",
            hint,
            after_last=True,
            feed=(feed,) if feed else (),
            resume=self.start if feed and resume is None else resume,
        )


def words(text: str, start: int, end: int, most: int = 400) -> list[Word]:
    """Return the tokens of text[start:end), at most `most`."""
    result: list[Word] = []
    for match in _WORD.finditer(text, start, min(end, len(text))):
        result.append(Word(match[0], match.start(), match.end()))
        if len(result) == most:
            break
    return result


def header(text: str, opening: int) -> list[Word]:
    """Return the tokens between the end of the previous declaration and a `{`."""
    low = max(0, opening - MAX_CONTEXT)
    begin = low
    for match in ENDS.finditer(text, low, opening):
        begin = match.end()
    return words(text, begin, opening)


def partner(text: str, closing: int) -> int | None:
    """Return the `{` that matches the `}` at `closing`."""
    depth = 0
    for place in range(closing, max(-1, closing - 100_000), -1):
        if text[place] == "}":
            depth += 1
        elif text[place] == "{":
            depth -= 1
            if depth == 0:
                return place
    return None
