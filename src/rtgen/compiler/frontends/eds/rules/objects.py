"""Rules of objects and sub-objects (EDS03xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NO_NAME = Rule("EDS0300", "object without a name", Severity.WARNING)
OBJECT_TYPE = Rule("EDS0301", "object type taken from the other keys", Severity.WARNING)
WORDS = Rule("EDS0302", "type in words", Severity.WARNING)
TYPE_TAKEN = Rule("EDS0303", "data type missing, but clear", Severity.WARNING)
NO_TYPE = Rule("EDS0304", "data type missing", Severity.ERROR)
UNKNOWN_TYPE = Rule("EDS0305", "unknown data type", Severity.WARNING)
NO_ACCESS = Rule("EDS0306", "access type missing", Severity.WARNING)
UNKNOWN_ACCESS = Rule("EDS0307", "unknown access type", Severity.WARNING)
ORPHAN = Rule("EDS0308", "sub-object without its object", Severity.WARNING)
OF_A_VAR = Rule("EDS0309", "sub-object of a variable", Severity.WARNING)
SUB_NUMBER = Rule("EDS0310", "wrong number of sub-objects", Severity.WARNING)
NO_SUBS = Rule("EDS0311", "object without sub-objects", Severity.WARNING)
NO_SUB0 = Rule("EDS0312", "sub-index 0 missing", Severity.WARNING)
SUB0_TYPE = Rule("EDS0313", "sub-index 0 is not UNSIGNED8", Severity.WARNING)
SUB0_VALUE = Rule("EDS0314", "wrong highest sub-index", Severity.WARNING)
ARRAY_TYPES = Rule("EDS0315", "array of several types", Severity.WARNING)
BAD_SUBINDEX = Rule("EDS0316", "impossible sub-index", Severity.WARNING)
COMPACT_COUNT = Rule(
    "EDS0317", "impossible number of compact sub-objects", Severity.WARNING
)
NOT_COMPACT = Rule("EDS0318", "entry for no sub-object", Severity.WARNING)
RESERVED_INDEX = Rule("EDS0319", "reserved index", Severity.WARNING)

RULES = rules_of(globals())
