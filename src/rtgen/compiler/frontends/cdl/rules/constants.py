"""Rules of constants, expressions and initialisers (CDL08xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NO_INITIALISER = Rule("CDL0800", "constant without a value", Severity.ERROR)
CONSTANT_TYPE = Rule("CDL0801", "type that a constant cannot have", Severity.ERROR)
NOT_CONST = Rule(
    "CDL0802", "declaration outside celltypes that is not const", Severity.ERROR
)
NOT_CONSTANT = Rule("CDL0803", "value that is not constant", Severity.ERROR)
UNKNOWN_NAME = Rule("CDL0804", "unknown name in an expression", Severity.ERROR)
CANNOT_EVALUATE = Rule(
    "CDL0805", "operator that cannot be evaluated here", Severity.ERROR
)
OPERATOR_KIND = Rule("CDL0806", "operator does not fit its operands", Severity.ERROR)
DIVISION = Rule("CDL0807", "division by zero", Severity.ERROR)
RANGE = Rule("CDL0808", "value out of range", Severity.ERROR)
NEEDS_CAST = Rule("CDL0809", "floating-point number for an integer", Severity.ERROR)
SHAPE = Rule("CDL0810", "initialiser of another shape", Severity.ERROR)
POINTER_VALUE = Rule("CDL0811", "value that a pointer cannot have", Severity.ERROR)
SURPLUS = Rule("CDL0812", "more values than a struct has members", Severity.WARNING)

RULES = rules_of(globals())
