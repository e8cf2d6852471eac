"""The rules of the formatter (codes FMT...)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NO_TOKENS = Rule("FMT0001", "text that cannot be formatted", Severity.ERROR)
OTHER_FILE = Rule("FMT0002", "file that cannot be formatted", Severity.ERROR)

RULES: tuple[Rule, ...] = (NO_TOKENS, OTHER_FILE)
