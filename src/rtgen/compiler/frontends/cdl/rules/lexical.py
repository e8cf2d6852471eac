"""Rules of words and symbols of CDL (CDL01xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

BAD_CHARACTER = Rule("CDL0100", "character that is not allowed here", Severity.ERROR)
UNCLOSED_COMMENT = Rule("CDL0101", "comment that is never closed", Severity.ERROR)
UNCLOSED_TEXT = Rule("CDL0102", "string that is never closed", Severity.ERROR)
DIRECTIVE = Rule("CDL0103", "preprocessor directive", Severity.ERROR)
ANGLE = Rule("CDL0104", "text between < and > taken for a file name", Severity.ERROR)
NUMBER = Rule("CDL0105", "number that CDL does not know", Severity.ERROR)

RULES = rules_of(globals())
