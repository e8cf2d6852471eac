"""Rules of constant expressions (IDL05xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

WRONG_KIND = Rule("IDL0500", "value of the wrong kind", Severity.ERROR)
OUT_OF_RANGE = Rule("IDL0501", "value out of range", Severity.ERROR)
DIVISION_BY_ZERO = Rule("IDL0502", "division by zero", Severity.ERROR)
BAD_SHIFT = Rule("IDL0503", "impossible shift", Severity.ERROR)
PRECISION = Rule("IDL0504", "fraction cut off", Severity.WARNING)
TEXT_TOO_LONG = Rule("IDL0505", "string longer than its bound", Severity.ERROR)
WRONG_ENUM = Rule("IDL0506", "enumerator of another enum", Severity.ERROR)
INTEGER_AS_FLOAT = Rule(
    "IDL0507", "integer where a floating-point number is expected", Severity.WARNING
)
NEGATIVE_REMAINDER = Rule("IDL0508", "remainder of a negative number", Severity.WARNING)
INFINITE = Rule("IDL0509", "number so large that it is infinite", Severity.WARNING)

RULES = rules_of(globals())
