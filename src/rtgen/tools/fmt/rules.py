"""Rules of the formatter (codes FMT...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NO_TOKENS = Rule("FMT0001", "text that cannot be formatted", Severity.ERROR)
OTHER_FILE = Rule("FMT0002", "file that cannot be formatted", Severity.ERROR)
NO_FORMATTER = Rule("FMT0003", "formatter that is not installed", Severity.WARNING)

RULES = rules_of(globals())
