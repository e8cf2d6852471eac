"""Rules of repository ids (IDL07xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

BAD_PRAGMA = Rule("IDL0700", "malformed pragma", Severity.ERROR)
NO_ID = Rule("IDL0701", "no repository id", Severity.ERROR)
ODD_ID = Rule("IDL0702", "unusual repository id", Severity.WARNING)
CONFLICT = Rule("IDL0703", "repository id set twice", Severity.ERROR)
SAME_ID = Rule("IDL0704", "one repository id for two declarations", Severity.WARNING)
UNKNOWN_PRAGMA = Rule("IDL0705", "unknown pragma", Severity.NOTE)

RULES = rules_of(globals())
