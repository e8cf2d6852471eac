"""Rules of bus files (EDS07xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

BAD_FILE = Rule("EDS0700", "bus file cannot be read", Severity.ERROR)
BAD_CONTENT = Rule(
    "EDS0701", "key or value that a bus file cannot have", Severity.ERROR
)
UNKNOWN_DEVICE = Rule("EDS0702", "unknown kind of device", Severity.ERROR)
SAME_ID = Rule("EDS0703", "node-id given twice", Severity.ERROR)
BAD_VALUE = Rule("EDS0704", "value for no object", Severity.ERROR)
BAD_MAPPING = Rule("EDS0705", "impossible PDO", Severity.ERROR)
SAME_COB_ID = Rule("EDS0706", "COB-ID used twice", Severity.ERROR)
BAD_LINK = Rule("EDS0707", "link without its ends", Severity.ERROR)
NO_BIT_RATE = Rule("EDS0708", "bit rate that a device does not have", Severity.WARNING)
OVERLOAD = Rule("EDS0709", "bus cannot carry its messages", Severity.WARNING)
NOT_LIKE_KIND = Rule("EDS0710", "node that is mapped unlike its kind", Severity.ERROR)
NO_SUPERVISION = Rule("EDS0711", "unsupervised node", Severity.WARNING)
NO_FACTOR = Rule("EDS0712", "factor that a drive does not state", Severity.ERROR)
OTHER_SYNC = Rule("EDS0713", "node without the SYNC of its network", Severity.ERROR)
CONSUMED_TWICE = Rule("EDS0714", "two consumers of one heartbeat", Severity.ERROR)
REFUSED_CHANGE = Rule("EDS0715", "value that a node may refuse", Severity.WARNING)
NO_SYNC = Rule("EDS0716", "PDO that waits for SYNC in vain", Severity.WARNING)
NO_LSS = Rule("EDS0717", "LSS that a device does not have", Severity.WARNING)

RULES = rules_of(globals())
