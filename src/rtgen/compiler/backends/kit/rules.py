"""The rules of text in generated files (codes PRJ0107 and later)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNQUOTABLE = Rule("PRJ0107", "text that an output cannot hold", Severity.ERROR)
TEMPLATE_FAULT = Rule("PRJ0108", "template that cannot be rendered", Severity.ERROR)

RULES = rules_of(globals())
