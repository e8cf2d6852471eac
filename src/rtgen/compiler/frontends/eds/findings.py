"""Collects the diagnostics of one EDS or DCF file."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.eds.rules import lexical
from rtgen.compiler.frontends.kit import findings

MAX_FINDINGS = 500
"""Maximum number of diagnostics of one severity per file."""


class Findings(findings.Findings):
    """Collects the diagnostics of one file."""

    _overflow: Rule | None = lexical.TOO_MANY_FINDINGS
    _most: int = MAX_FINDINGS

    @property
    def failed(self) -> bool:
        """Whether there are errors."""
        return self.errors > 0
