"""Rules of FileInfo, DeviceInfo, commissioning and the lists of objects (EDS02xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_SECTION = Rule("EDS0200", "section missing", Severity.WARNING)
MISSING_KEYS = Rule("EDS0201", "keys missing", Severity.NOTE)
BAD_INFORMATION = Rule("EDS0202", "value that the key cannot have", Severity.WARNING)
WRONG_COUNT = Rule("EDS0203", "wrong count", Severity.WARNING)
BAD_ENTRY = Rule("EDS0204", "entry is not an index", Severity.WARNING)
NOT_THERE = Rule("EDS0205", "listed object is not described", Severity.WARNING)
NOT_LISTED = Rule("EDS0206", "object in no list", Severity.WARNING)
WRONG_LIST = Rule("EDS0207", "object in the wrong list", Severity.WARNING)
LISTED_TWICE = Rule("EDS0208", "object listed twice", Severity.WARNING)
MANDATORY_OBJECT = Rule("EDS0209", "mandatory object missing", Severity.WARNING)
PDO_COUNT = Rule("EDS0210", "wrong number of PDOs", Severity.WARNING)
NODE_ID = Rule("EDS0211", "impossible node-id", Severity.WARNING)
BIT_RATE = Rule("EDS0212", "unusual bit rate", Severity.WARNING)
OF_A_DCF = Rule("EDS0213", "part of a DCF in an EDS", Severity.WARNING)
OTHER_IDENTITY = Rule("EDS0214", "two identities", Severity.WARNING)
BAD_DUMMY = Rule("EDS0215", "no data type for a gap", Severity.WARNING)

RULES = rules_of(globals())
