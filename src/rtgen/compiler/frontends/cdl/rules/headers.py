"""Rules of C headers (CDL09xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_HEADER = Rule("CDL0900", "C header not found", Severity.ERROR)
UNREADABLE_HEADER = Rule("CDL0901", "C header that is not understood", Severity.ERROR)
HEADER_TWICE = Rule(
    "CDL0902", "C header imported with other definitions", Severity.ERROR
)
MISSING_INCLUDE = Rule(
    "CDL0903", "file included by a C header not found", Severity.WARNING
)
HEADER_LIMIT = Rule("CDL0904", "C header too large", Severity.ERROR)
HEADER_REDEFINES = Rule("CDL0905", "C type declared differently", Severity.WARNING)
HEADER_DEFINITION = Rule("CDL0906", "malformed definition", Severity.ERROR)

RULES = rules_of(globals())
