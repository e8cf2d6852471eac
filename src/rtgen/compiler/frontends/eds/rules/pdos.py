"""Rules of PDOs (EDS05xx). A PDO that violates one is still read."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

HALF = Rule("EDS0500", "PDO without one of its two objects", Severity.WARNING)
NO_OBJECT = Rule("EDS0501", "mapped object does not exist", Severity.WARNING)
NOT_MAPPABLE = Rule("EDS0502", "mapped object cannot be mapped", Severity.WARNING)
OTHER_LENGTH = Rule("EDS0503", "mapped length is not the type's", Severity.WARNING)
TOO_LONG = Rule("EDS0504", "PDO too long", Severity.WARNING)
WRONG_WAY = Rule("EDS0505", "access does not fit the PDO", Severity.WARNING)
BAD_NUMBER = Rule("EDS0506", "wrong number of mapped objects", Severity.WARNING)
BAD_COB_ID = Rule("EDS0507", "COB-ID that a PDO cannot have", Severity.WARNING)
BAD_TRANSMISSION = Rule("EDS0508", "reserved transmission type", Severity.WARNING)
BAD_GAP = Rule("EDS0509", "gap that is not allowed", Severity.WARNING)
SAME_COB_ID = Rule("EDS0510", "two PDOs with one COB-ID", Severity.WARNING)
GRANULARITY = Rule("EDS0511", "finer than the granularity", Severity.WARNING)
MAPPED_TWICE = Rule("EDS0512", "object mapped twice", Severity.WARNING)
EMPTY_ENTRY = Rule("EDS0513", "empty entry in use", Severity.WARNING)
NO_NODE_ID = Rule("EDS0514", "COB-ID without the node-id", Severity.WARNING)
MULTIPLEXED = Rule("EDS0515", "multiplexed PDO", Severity.WARNING)

RULES = rules_of(globals())
