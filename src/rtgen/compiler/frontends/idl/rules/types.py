"""Rules of types and unions (IDL03xx, IDL04xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

INCOMPLETE = Rule("IDL0300", "type used before it is complete", Severity.ERROR)
BAD_BASE = Rule("IDL0301", "not a possible base", Severity.ERROR)
READ_ONLY = Rule("IDL0302", "construct without generated code", Severity.WARNING)
LEFT_OUT = Rule("IDL0309", "declaration that is left out", Severity.WARNING)
VOID = Rule("IDL0303", "void outside of a return type", Severity.ERROR)
BAD_BOUND = Rule("IDL0304", "bound or dimension that is not positive", Severity.ERROR)
BAD_FIXED = Rule("IDL0305", "impossible fixed-point type", Severity.ERROR)
ANONYMOUS = Rule("IDL0306", "anonymous type where a name is needed", Severity.ERROR)
RECURSIVE_SEQUENCE = Rule("IDL0307", "anonymous recursive sequence", Severity.WARNING)
LOCAL_TYPE = Rule("IDL0308", "local type in a remote interface", Severity.ERROR)
BAD_CONST_TYPE = Rule("IDL0310", "type that no constant can have", Severity.ERROR)
BAD_MAP_KEY = Rule("IDL0311", "impossible key of a map", Severity.ERROR)
BAD_BITFIELD = Rule("IDL0312", "impossible bit field", Severity.ERROR)
LONG_DOUBLE = Rule("IDL0313", "long double in a constant", Severity.WARNING)
TOO_DEEP = Rule(
    "IDL0314", "declarations that refer to each other too deep", Severity.ERROR
)
BAD_SWITCH = Rule("IDL0400", "impossible switch of a union", Severity.ERROR)
DUPLICATE_LABEL = Rule("IDL0401", "label given twice", Severity.ERROR)
SECOND_DEFAULT = Rule("IDL0402", "second default", Severity.ERROR)
SUPERFLUOUS_DEFAULT = Rule(
    "IDL0403", "default that can never be chosen", Severity.ERROR
)
EMPTY_UNION = Rule("IDL0404", "union without branches", Severity.ERROR)

RULES = rules_of(globals())
