"""The rules of `RTCPlugin`: its options, and signatures without an interface (CDL10xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNKNOWN_OPTION = Rule("CDL1001", "unknown option of RTCPlugin", Severity.ERROR)
BAD_OPTION = Rule(
    "CDL1002", "value that an option of RTCPlugin cannot have", Severity.ERROR
)
NOT_IN_IDL = Rule("CDL1003", "type that no IDL interface can have", Severity.ERROR)
DIFFERENT_OPTIONS = Rule(
    "CDL1004", "two joins that want different interfaces", Severity.ERROR
)
SAME_NAME = Rule("CDL1005", "two signatures with one name in Python", Severity.ERROR)
SAME_COMPONENT = Rule("CDL1006", "two component types of one name", Severity.WARNING)
NOT_TRANSFERRED = Rule(
    "CDL1007", "parameter that OpaqueRPC cannot carry", Severity.ERROR
)
SIZE_TOO_EARLY = Rule(
    "CDL1008", "size that the board reads before the call", Severity.WARNING
)
SAME_CHANNEL = Rule("CDL1009", "one channel for two joins", Severity.WARNING)

RULES = rules_of(globals())
