"""Rules of signatures: functions and their parameters (CDL04xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

CONTEXT_UNKNOWN = Rule("CDL0400", "unknown context", Severity.WARNING)
SPECIFIER_TWICE = Rule("CDL0401", "specifier given twice", Severity.ERROR)
NOT_A_FUNCTION = Rule("CDL0402", "not a function", Severity.ERROR)
FUNCTION_TWICE = Rule("CDL0403", "function declared twice", Severity.ERROR)
NO_VOID = Rule("CDL0404", "function without void", Severity.WARNING)
RETURNS_POINTER = Rule("CDL0405", "function returns a pointer", Severity.WARNING)
NO_BRACKET = Rule("CDL0406", "parameter without specifiers", Severity.ERROR)
NO_NAME = Rule("CDL0407", "parameter without a name", Severity.ERROR)
NO_DIRECTION = Rule("CDL0408", "parameter without a direction", Severity.ERROR)
DIRECTION_CONFLICT = Rule("CDL0409", "two directions", Severity.ERROR)
DIRECTION_TWICE = Rule("CDL0410", "direction given twice", Severity.WARNING)
ALLOCATOR = Rule("CDL0411", "no allocator signature", Severity.ERROR)
STRING_LENGTH = Rule("CDL0412", "string without a length", Severity.WARNING)
TOO_FEW_POINTERS = Rule("CDL0413", "parameter is not a pointer", Severity.ERROR)
TOO_MANY_POINTERS = Rule("CDL0414", "pointer to a pointer", Severity.WARNING)
IN_NOT_CONST = Rule("CDL0415", "in pointer whose target is not const", Severity.ERROR)
OUT_CONST = Rule("CDL0416", "const where something is written", Severity.ERROR)
SIZE_OF_SCALAR = Rule(
    "CDL0417", "size of something other than a pointer", Severity.ERROR
)
SIZE_OF_VOID = Rule("CDL0418", "size of a void pointer", Severity.ERROR)
NULLABLE_SIZE = Rule("CDL0419", "array that may be NULL", Severity.ERROR)
SIZE_TYPE = Rule("CDL0420", "size is not an integer", Severity.ERROR)
SIZE_SIGN = Rule("CDL0421", "size that is not positive", Severity.ERROR)
MAX_SIZE = Rule("CDL0422", "invalid limit", Severity.ERROR)
SIZE_OVER_MAX = Rule("CDL0423", "size above its limit", Severity.ERROR)
SIZE_UNDER_MAX = Rule("CDL0424", "limit without effect", Severity.WARNING)
LENGTH_DIRECTION = Rule(
    "CDL0425", "length passed in the opposite direction", Severity.ERROR
)
ONEWAY_RETURN = Rule(
    "CDL0426", "oneway function that returns something", Severity.ERROR
)
ONEWAY_PARAMETER = Rule(
    "CDL0427", "oneway function with an outward parameter", Severity.ERROR
)
PARAMETER_TWICE = Rule("CDL0428", "parameter declared twice", Severity.ERROR)
FUNCTION_PARAMETER = Rule("CDL0429", "parameter that is a function", Severity.ERROR)
SIZE_FORM = Rule("CDL0430", "size that tecsgen does not understand", Severity.WARNING)

RULES = rules_of(globals())
