"""Rules of RtcProfile files (RTC0530 and following)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_A_PROFILE = Rule("RTC0530", "not an RtcProfile", Severity.ERROR)
MISSING = Rule("RTC0531", "the component has no name", Severity.ERROR)
LEFT_OUT = Rule(
    "RTC0532", "element required by the schema is left out", Severity.WARNING
)
MISSPELT = Rule("RTC0533", "misspelt or misplaced attribute", Severity.WARNING)
UNKNOWN_WORD = Rule("RTC0534", "unknown word", Severity.WARNING)
BAD_NUMBER = Rule("RTC0535", "bad number", Severity.WARNING)
BAD_DATE = Rule("RTC0536", "bad date", Severity.WARNING)
UNKNOWN_TYPE = Rule("RTC0537", "type not found", Severity.WARNING)
WRONG_TYPE = Rule("RTC0538", "type is of another kind", Severity.WARNING)
PARAMETER_TYPE = Rule("RTC0539", "unknown type of a parameter", Severity.WARNING)
PARAMETER_VALUE = Rule(
    "RTC0540", "default is not a value of the parameter's type", Severity.WARNING
)
CONSTRAINT = Rule("RTC0541", "unsupported constraint", Severity.WARNING)
TWICE = Rule("RTC0542", "two of one name", Severity.WARNING)
NAME = Rule("RTC0543", "name is taken differently", Severity.WARNING)
SAME_COMPONENT = Rule("RTC0544", "component defined twice", Severity.ERROR)
FACTS = Rule("RTC0546", "property of rtgen that cannot be used", Severity.WARNING)
LOST = Rule("RTC0547", "incomplete element", Severity.WARNING)
BAD_WIDGET = Rule("RTC0548", "unsupported widget", Severity.WARNING)
DISAGREES = Rule("RTC0549", "profile and IDL disagree", Severity.WARNING)

RULES = rules_of(globals())
