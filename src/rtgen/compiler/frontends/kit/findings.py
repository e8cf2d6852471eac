"""Collects diagnostics: each once, and at most a maximum per severity."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import msgspec
from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, Rule, Severity, Span

MAX_PER_SEVERITY = 1000
"""Maximum number of diagnostics kept per severity."""


class Findings(msgspec.Struct, eq=False):
    """Collects diagnostics in the order of reporting.

    `overflow` is the rule of the diagnostic that replaces those beyond `most` of one severity; for
    warnings and notes it is a note.
    Without it, one more than `most` is kept, so that a collection to which they are reported
    overflows, too.
    """

    _overflow: Rule | None = None
    _most: int = MAX_PER_SEVERITY
    _diagnostics: dict[Diagnostic, None] = {}
    _counts: Counter[Severity] = msgspec.field(default_factory=Counter)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The kept diagnostics."""
        return tuple(self._diagnostics)

    @property
    def errors(self) -> int:
        """Number of errors reported, including dropped ones."""
        return self._counts[Severity.ERROR]

    def report(self, diagnostic: Diagnostic) -> None:
        """Keep a diagnostic, unless it is a duplicate or exceeds the maximum."""
        if diagnostic in self._diagnostics:
            return
        severity = diagnostic.severity
        self._counts[severity] += 1
        if self._counts[severity] <= self._most:
            self._diagnostics[diagnostic] = None
        elif self._counts[severity] > self._most + 1:
            return
        elif self._overflow is None:
            self._diagnostics[diagnostic] = None
        else:
            message = f"more than {self._most} {severity}s: the rest is not shown"
            overflow = self._overflow.at(diagnostic.span, message)
            if severity is not Severity.ERROR:
                overflow = replace(overflow, severity=Severity.NOTE)
            self._diagnostics[overflow] = None

    def add(
        self, rule: Rule, span: Span, message: str, *, hint: str | None = None
    ) -> None:
        """Report a diagnostic of a rule."""
        self.report(rule.at(span, message, hint=hint))

    def rewrite(self, change: Callable[[Diagnostic], Diagnostic]) -> None:
        """Replace each diagnostic by the result of `change`."""
        self._diagnostics = dict.fromkeys(map(change, self._diagnostics))

    def forget(self, file: str | None) -> None:
        """Drop the diagnostics in a file."""
        self._diagnostics = {
            d: None
            for d in self._diagnostics
            if (d.span.file if d.span else None) != file
        }
