"""Rules of syntax (CDL02xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNEXPECTED = Rule("CDL0200", "syntax error", Severity.ERROR)
MISSING_SEMICOLON = Rule("CDL0201", "missing semicolon", Severity.ERROR)
MISSPELT_KEYWORD = Rule("CDL0202", "misspelt keyword", Severity.ERROR)
KEYWORD_AS_NAME = Rule("CDL0203", "keyword used as a name", Severity.ERROR)
TYPE_AS_NAME = Rule("CDL0204", "type used as a name", Severity.ERROR)
UNCLOSED_BRACE = Rule("CDL0205", "brace that is never closed", Severity.ERROR)
STRAY_BRACE = Rule("CDL0206", "unmatched closing brace", Severity.ERROR)
UNEXPECTED_END = Rule("CDL0207", "file ends too early", Severity.ERROR)
EMPTY_BLOCK = Rule("CDL0208", "block without content", Severity.ERROR)
EXTRA_SEMICOLON = Rule("CDL0209", "extra semicolon", Severity.ERROR)
TOO_MANY = Rule("CDL0210", "too many syntax errors", Severity.ERROR)
TOO_DEEP = Rule("CDL0211", "nested too deeply", Severity.ERROR)
MISSING_MARK = Rule("CDL0212", "missing punctuation", Severity.ERROR)
QUALIFIER = Rule("CDL0213", "qualifier after the type", Severity.ERROR)
MISPLACED_SPECIFIER = Rule(
    "CDL0214", "specifier that is not allowed here", Severity.ERROR
)
UNKNOWN_SPECIFIER = Rule("CDL0215", "unknown specifier", Severity.ERROR)

RULES = rules_of(globals())
