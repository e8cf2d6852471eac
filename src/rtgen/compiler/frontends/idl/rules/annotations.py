"""Rules of annotations and components (IDL08xx, IDL09xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_ANNOTATION = Rule("IDL0800", "unknown annotation", Severity.WARNING)
MISPLACED = Rule("IDL0801", "annotation in the wrong place", Severity.WARNING)
BAD_ARGUMENT = Rule("IDL0802", "wrong argument of an annotation", Severity.ERROR)
KEY_OPTIONAL = Rule("IDL0803", "optional key", Severity.ERROR)
DUPLICATE_ID = Rule("IDL0804", "member id given twice", Severity.ERROR)
BAD_BIT_BOUND = Rule("IDL0805", "impossible @bit_bound or @position", Severity.ERROR)
BAD_ENUM_VALUE = Rule("IDL0806", "impossible value of an enumerator", Severity.ERROR)
EXTENSIBILITY = Rule("IDL0807", "conflicting extensibility", Severity.ERROR)
DEFAULT_RANGE = Rule("IDL0808", "default or range that does not fit", Severity.ERROR)
REPEATED = Rule("IDL0809", "annotation given twice", Severity.ERROR)
BAD_PORT_TYPE = Rule("IDL0900", "impossible type of a port", Severity.ERROR)
DUPLICATE_PORT = Rule("IDL0901", "port declared twice", Severity.ERROR)
BAD_PARAMETER_TYPE = Rule(
    "IDL0902", "impossible type of a configuration parameter", Severity.ERROR
)
BAD_NAME = Rule("IDL0903", "impossible outside name", Severity.ERROR)
BAD_DATE = Rule("IDL0904", "malformed date", Severity.ERROR)
PASSED_OVER = Rule(
    "IDL0905", "construct of components that is read only", Severity.WARNING
)

RULES = rules_of(globals())
