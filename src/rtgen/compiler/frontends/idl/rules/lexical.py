"""Rules of files, characters and the preprocessor (IDL00xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_FILE = Rule("IDL0001", "file not found", Severity.ERROR)
UNREADABLE = Rule("IDL0002", "file cannot be read", Severity.ERROR)
BINARY = Rule("IDL0003", "not a text file", Severity.ERROR)
BAD_CHARACTER = Rule("IDL0004", "character that is not allowed here", Severity.ERROR)
FILE_TOO_LARGE = Rule("IDL0006", "file too large", Severity.ERROR)
UNCLOSED_COMMENT = Rule("IDL0007", "comment that is never closed", Severity.ERROR)
INCLUDE_NOT_FOUND = Rule("IDL0010", "included file not found", Severity.ERROR)
INCLUDE_CYCLE = Rule("IDL0011", "includes without end", Severity.ERROR)
BAD_INCLUDE = Rule("IDL0012", "malformed #include", Severity.ERROR)
UNCLOSED_CONDITIONAL = Rule(
    "IDL0013", "conditional that is never closed", Severity.ERROR
)
STRAY_CONDITIONAL = Rule(
    "IDL0014", "#else, #elif or #endif in the wrong place", Severity.ERROR
)
BAD_CONDITION = Rule("IDL0015", "condition that cannot be evaluated", Severity.ERROR)
BAD_DEFINITION = Rule("IDL0016", "malformed #define", Severity.ERROR)
MACRO_REDEFINED = Rule("IDL0017", "macro defined again, differently", Severity.WARNING)
BAD_MACRO_CALL = Rule("IDL0018", "macro that cannot be expanded", Severity.ERROR)
ERROR_DIRECTIVE = Rule("IDL0019", "#error", Severity.ERROR)
WARNING_DIRECTIVE = Rule("IDL0020", "#warning", Severity.WARNING)
UNKNOWN_DIRECTIVE = Rule("IDL0021", "unknown directive", Severity.ERROR)
BAD_LINE_MARKER = Rule("IDL0022", "malformed line marker", Severity.ERROR)
BAD_MACRO_NAME = Rule("IDL0023", "macro name is not an identifier", Severity.ERROR)
INCLUDED_AGAIN = Rule("IDL0024", "file included again without a guard", Severity.NOTE)
NAMELESS_CONDITION = Rule(
    "IDL0025", "conditional without the name of a macro", Severity.WARNING
)
PASSED_OVER = Rule("IDL0026", "directive without effect", Severity.WARNING)
TIME_OF_TRANSLATION = Rule("IDL0027", "date or time of translation", Severity.WARNING)

RULES = rules_of(globals())
