"""Rules of descriptions in XML (EDS012x)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NAMESPACE = Rule("EDS0120", "other namespace", Severity.WARNING)
MISSING_PART = Rule("EDS0121", "part of an XDD missing", Severity.WARNING)
BAD_PART = Rule("EDS0122", "part of an XDD that cannot be read", Severity.WARNING)
NO_TARGET = Rule("EDS0123", "reference to nothing", Severity.WARNING)
SAME_ID = Rule("EDS0124", "identifier given twice", Severity.WARNING)
TWO_TYPES = Rule("EDS0125", "object and parameter of two types", Severity.WARNING)
NOT_READ = Rule("EDS0126", "part of an XDD that is not read", Severity.NOTE)

RULES = rules_of(globals())
