"""Rules of `rtgen lint` (LINT...): warnings for likely errors, notes for style."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNUSED_INCLUDE = Rule("LINT0001", "unused include", Severity.WARNING)
UNUSED_TYPEDEF = Rule("LINT0002", "unused typedef", Severity.NOTE)
ANONYMOUS_TYPE = Rule("LINT0003", "anonymous type", Severity.NOTE)
NAMING = Rule("LINT0004", "inconsistent name", Severity.WARNING)
UNDOCUMENTED = Rule("LINT0005", "no comment", Severity.NOTE)
NO_PREFIX = Rule("LINT0006", "repository id without prefix", Severity.NOTE)
ANY_IN_PORT = Rule("LINT0007", "any in the data of a port", Severity.WARNING)
NO_TIME = Rule("LINT0008", "data of a port without a time", Severity.WARNING)
UNBOUNDED = Rule("LINT0009", "no bound", Severity.WARNING)
MISSING_ENUMERATORS = Rule("LINT0010", "enumerators without a branch", Severity.WARNING)
PYTHON_NAME = Rule("LINT0011", "name that differs in Python", Severity.NOTE)
NO_HEARTBEAT = Rule("LINT0012", "device without heartbeat", Severity.WARNING)
NO_VENDOR = Rule("LINT0013", "device without a vendor number", Severity.WARNING)
SAME_NAME = Rule("LINT0014", "objects of one name", Severity.NOTE)
NO_EFFECT = Rule("LINT0015", "suppression without effect", Severity.WARNING)
NOT_CARRIED = Rule("LINT0016", "function that no transport can carry", Severity.NOTE)
UNREACHABLE = Rule("LINT0017", "object that nobody can read", Severity.NOTE)
UNBOUNDED_ON_BOARD = Rule(
    "LINT0018", "data without a bound on a board", Severity.WARNING
)
UNUSED_TYPE = Rule("LINT0019", "unused type", Severity.NOTE)
NOT_PORTABLE = Rule("LINT0020", "IDL that other compilers refuse", Severity.NOTE)
UNKNOWN_UNIT = Rule("LINT0021", "text that is not a unit", Severity.WARNING)
OTHER_FACTOR = Rule("LINT0022", "factor other than that of the drive", Severity.WARNING)
DEVICE_NAME = Rule("LINT0023", "file name reserved by Windows", Severity.WARNING)
MISSPELT_UNIT = Rule("LINT0024", "misspelt unit", Severity.WARNING)

RULES = rules_of(globals())

ON_DEMAND: tuple[Rule, ...] = (UNDOCUMENTED, UNBOUNDED, NOT_PORTABLE)
"""Rules that only run if selected."""
