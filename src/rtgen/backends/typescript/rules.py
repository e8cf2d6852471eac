"""The rule of declarations without a codec in TypeScript."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NOT_IN_TYPESCRIPT = Rule(
    "TS0001", "declaration without a codec in TypeScript", Severity.WARNING
)

RULES = (NOT_IN_TYPESCRIPT,)
