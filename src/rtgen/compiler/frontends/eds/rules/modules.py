"""Rules of modular devices (EDS06xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NO_MODULE = Rule("EDS0600", "unknown module", Severity.WARNING)
NOTHING_TO_EXTEND = Rule("EDS0601", "module extends no object", Severity.WARNING)

RULES = rules_of(globals())
