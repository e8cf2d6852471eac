"""The rule of texts that an output language cannot represent (PRJ0107)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity, rules_of

UNQUOTABLE = Rule("PRJ0107", "text that an output cannot hold", Severity.ERROR)

RULES = rules_of(globals())
