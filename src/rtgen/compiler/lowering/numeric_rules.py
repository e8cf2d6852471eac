"""The rule of `@numeric` (code NUM...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NO_NUMBERS = Rule("NUM0001", "@numeric where there are no numbers", Severity.ERROR)

RULES = rules_of(globals())
