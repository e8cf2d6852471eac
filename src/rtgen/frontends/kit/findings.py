"""The findings of a run: each once, and of each severity no more than a bound."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from rtgen.diagnostics import Diagnostic, Rule, Severity, Span

MOST = 1000
"""How many findings of one severity are kept."""


class Findings:
    """Collects diagnostics in the order of reporting.

    `overflow` is the rule of the diagnostic that stands for those beyond `most` of one severity;
    without it one more than `most` is kept, so that findings that these are reported to overflow.
    """

    def __init__(self, overflow: Rule | None = None, most: int = MOST) -> None:
        self._overflow = overflow
        self._most = most
        self._found: dict[Diagnostic, None] = {}
        self._counts: Counter[Severity] = Counter()

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The diagnostics that are kept."""
        return tuple(self._found)

    @property
    def errors(self) -> int:
        """How many errors were reported, those beyond the bound included."""
        return self._counts[Severity.ERROR]

    def report(self, diagnostic: Diagnostic) -> None:
        """Keep a diagnostic, unless it is known or there are too many."""
        if diagnostic in self._found:
            return
        severity = diagnostic.severity
        self._counts[severity] += 1
        if self._counts[severity] <= self._most:
            self._found[diagnostic] = None
        elif self._counts[severity] > self._most + 1:
            return
        elif self._overflow is None:
            self._found[diagnostic] = None
        else:
            message = f"more than {self._most} {severity}s: the rest is not shown"
            self._found[self._overflow.at(diagnostic.span, message)] = None

    def add(
        self, rule: Rule, span: Span, message: str, *, hint: str | None = None
    ) -> None:
        """Report a diagnostic of a rule."""
        self.report(rule.at(span, message, hint=hint))

    def rewrite(self, change: Callable[[Diagnostic], Diagnostic]) -> None:
        """Put what `change` makes of each diagnostic in its place."""
        self._found = dict.fromkeys(map(change, self._found))

    def forget(self, file: str | None) -> None:
        """Drop the diagnostics in a file."""
        self._found = {
            d: None for d in self._found if (d.span.file if d.span else None) != file
        }
