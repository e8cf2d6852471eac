"""Rules of the target small."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

LEFT_OUT = Rule("RTC0600", "component without a small form", Severity.WARNING)

RULES = rules_of(globals())
