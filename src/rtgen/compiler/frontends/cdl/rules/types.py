"""Rules of types and declarations (CDL03xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_TYPE = Rule("CDL0300", "unknown type", Severity.ERROR)
DECLARED_TWICE = Rule("CDL0301", "name declared twice", Severity.ERROR)
UNKNOWN_STRUCT = Rule("CDL0302", "unknown struct", Severity.ERROR)
SIGN_OF_SIZED = Rule("CDL0303", "sign of a type with a size", Severity.WARNING)
SIGN_TWICE = Rule("CDL0304", "sign given twice", Severity.ERROR)
ARRAY_SIZE = Rule("CDL0305", "invalid array size", Severity.ERROR)
VOID_VALUE = Rule("CDL0306", "nothing can be of type void", Severity.ERROR)
MEMBER_TWICE = Rule("CDL0307", "member declared twice", Severity.ERROR)
ENUM_TYPE = Rule("CDL0308", "enum not usable in calls", Severity.WARNING)
MEMBER_SIZE = Rule("CDL0309", "size of a member other than a pointer", Severity.ERROR)
UNKNOWN_NAME = Rule("CDL0310", "nothing of that name", Severity.ERROR)
WRONG_KIND = Rule("CDL0311", "name of another kind", Severity.ERROR)
GUESSED_TYPE = Rule("CDL0312", "type of a missing file", Severity.WARNING)

RULES = rules_of(globals())
