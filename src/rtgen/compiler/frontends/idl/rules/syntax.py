"""Rules of syntax (IDL01xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNEXPECTED = Rule("IDL0100", "syntax error", Severity.ERROR)
MISSING_SEMICOLON = Rule("IDL0101", "missing semicolon", Severity.ERROR)
MISSPELT_KEYWORD = Rule("IDL0102", "misspelt keyword", Severity.ERROR)
KEYWORD_AS_NAME = Rule("IDL0103", "keyword used as a name", Severity.ERROR)
MISSING_NAME = Rule("IDL0104", "declaration without a name", Severity.ERROR)
UNCLOSED_BRACE = Rule("IDL0105", "brace that is never closed", Severity.ERROR)
STRAY_BRACE = Rule("IDL0106", "unmatched closing brace", Severity.ERROR)
UNEXPECTED_END = Rule("IDL0107", "file ends too early", Severity.ERROR)
UNCLOSED_TEXT = Rule("IDL0108", "string that is never closed", Severity.ERROR)
BAD_LITERAL = Rule("IDL0109", "malformed literal", Severity.ERROR)
EXTRA_SEMICOLON = Rule("IDL0110", "extra semicolon", Severity.WARNING)
TOO_MANY = Rule("IDL0111", "too many syntax errors", Severity.ERROR)
TOO_DEEP = Rule("IDL0112", "nested too deeply", Severity.ERROR)
UNKNOWN_ESCAPE = Rule("IDL0113", "unknown escape", Severity.WARNING)
BROKEN_STRING = Rule("IDL0114", "string over several lines", Severity.WARNING)
TRAILING_COMMA = Rule("IDL0115", "comma after the last enumerator", Severity.ERROR)
EMPTY_ENUM = Rule("IDL0116", "enum without enumerators", Severity.ERROR)
ENUMERATOR_VALUE = Rule("IDL0117", "enumerator with a value", Severity.ERROR)
MISSING_DIRECTION = Rule("IDL0118", "parameter without direction", Severity.ERROR)
EMPTY_RAISES = Rule("IDL0119", "empty list of exceptions", Severity.ERROR)
TOO_MANY_FINDINGS = Rule("IDL0120", "too many findings", Severity.WARNING)
FOREIGN = Rule("IDL0121", "construct of another language", Severity.ERROR)
MISPLACED = Rule("IDL0122", "declaration that is not allowed here", Severity.ERROR)
BAD_ARRAY = Rule("IDL0123", "array written another way", Severity.ERROR)
MISSING_MARK = Rule("IDL0124", "missing punctuation", Severity.ERROR)
MISSING_WORD = Rule("IDL0125", "missing name, type or value", Severity.ERROR)
OTHER_LANGUAGE = Rule("IDL0126", "another interface language", Severity.ERROR)

RULES = rules_of(globals())
