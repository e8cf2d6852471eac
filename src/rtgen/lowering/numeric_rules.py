"""The rule of `@numeric` (code NUM...)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NO_NUMBERS = Rule("NUM0001", "@numeric where there are no numbers", Severity.ERROR)

RULES: tuple[Rule, ...] = (NO_NUMBERS,)
