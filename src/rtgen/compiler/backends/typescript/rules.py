"""The rule of declarations without a codec in TypeScript."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_IN_TYPESCRIPT = Rule(
    "TS0001", "declaration without a codec in TypeScript", Severity.WARNING
)

RULES = rules_of(globals())
