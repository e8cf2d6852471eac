"""Rules of values and limits (EDS04xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

BAD_VALUE = Rule("EDS0400", "value that its type does not have", Severity.WARNING)
OCTAL = Rule("EDS0401", "number that may be octal", Severity.WARNING)
FORMULA = Rule("EDS0402", "formula in another form", Severity.WARNING)
OUT_OF_RANGE = Rule("EDS0403", "value out of its type's range", Severity.WARNING)
OUTSIDE_LIMITS = Rule("EDS0404", "value outside the limits", Severity.WARNING)
LIMITS_CROSSED = Rule("EDS0405", "limits exchanged", Severity.WARNING)
NO_LIMIT = Rule("EDS0406", "limit for a type without order", Severity.WARNING)
ODD_NUMBER = Rule("EDS0407", "number in an unusual form", Severity.WARNING)
BAD_COB_ID = Rule("EDS0408", "COB-ID that a service cannot have", Severity.WARNING)

RULES = rules_of(globals())
