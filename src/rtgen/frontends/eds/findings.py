"""The findings of a run, bounded in number."""

from __future__ import annotations

from collections import Counter

from rtgen.diagnostics import Diagnostic, Rule, Severity, Span
from rtgen.frontends.eds.rules import lexical

MAX_FINDINGS = 500
"""How many findings of one severity are kept of a file."""


class Findings:
    """Collects what is found in one file."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._counts: Counter[Severity] = Counter()

    @property
    def failed(self) -> bool:
        """Whether there are errors."""
        return self._counts[Severity.ERROR] > 0

    def add(
        self, rule: Rule, span: Span, message: str, *, hint: str | None = None
    ) -> None:
        """Keeps a finding, if there are not too many already."""
        self._counts[rule.severity] += 1
        count = self._counts[rule.severity]
        if count <= MAX_FINDINGS:
            self.diagnostics.append(rule.at(span, message, hint=hint))
        elif count == MAX_FINDINGS + 1:
            message = (
                f"more than {MAX_FINDINGS} {rule.severity}s: the rest is not shown"
            )
            self.diagnostics.append(lexical.TOO_MANY_FINDINGS.at(span, message))
