"""Rules of interfaces, operations and valuetypes (IDL06xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

DUPLICATE_BASE = Rule("IDL0600", "base named twice", Severity.ERROR)
ABSTRACT_BASE = Rule(
    "IDL0601", "abstract interface or valuetype with a concrete base", Severity.ERROR
)
LOCAL_BASE = Rule("IDL0602", "remote interface with a local base", Severity.ERROR)
REDEFINED = Rule(
    "IDL0603", "inherited operation or attribute declared again", Severity.ERROR
)
INHERITED_CLASH = Rule("IDL0604", "two bases with one operation", Severity.ERROR)
NOT_RAISABLE = Rule("IDL0605", "not an exception", Severity.ERROR)
RAISED_TWICE = Rule("IDL0606", "exception named twice", Severity.WARNING)
ONEWAY = Rule("IDL0607", "impossible oneway operation", Severity.ERROR)
BAD_CONTEXT = Rule("IDL0608", "malformed context name", Severity.ERROR)
CONCRETE_BASES = Rule("IDL0609", "concrete base in the wrong place", Severity.ERROR)
CUSTOM = Rule("IDL0610", "custom valuetype in the wrong place", Severity.ERROR)
ABSTRACT_STATE = Rule("IDL0611", "state in an abstract valuetype", Severity.ERROR)
BOXED_VALUE = Rule("IDL0612", "boxed valuetype", Severity.ERROR)
BAD_PARAMETER = Rule("IDL0613", "impossible parameter of a factory", Severity.ERROR)
BAD_CLAUSE = Rule(
    "IDL0614", "exceptions of an attribute named the wrong way", Severity.ERROR
)
NOTHING_TO_TRUNCATE = Rule(
    "IDL0615", "truncatable without a concrete base", Severity.WARNING
)

RULES = rules_of(globals())
