"""The rules of reading profiles and systems."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

BAD_YAML = Rule("RTC0545", "not a profile in YAML", Severity.ERROR)
UNREADABLE = Rule("RTC0505", "profile cannot be opened", Severity.ERROR)
TOO_MANY = Rule("RTC0506", "too many findings", Severity.WARNING)
NOT_A_SYSTEM = Rule("RTC0510", "not an RtsProfile", Severity.ERROR)
MISSING = Rule("RTC0511", "attribute missing", Severity.ERROR)
SAME_INSTANCE = Rule("RTC0512", "two components of one name", Severity.ERROR)
UNKNOWN_INSTANCE = Rule("RTC0513", "unknown instance", Severity.ERROR)
NO_END = Rule("RTC0514", "connector without its two ends", Severity.ERROR)
NUMBER = Rule("RTC0515", "bad number", Severity.ERROR)
CYCLE = Rule("RTC0516", "activation waits for itself", Severity.ERROR)
ID = Rule("RTC0517", "id without a component type", Severity.ERROR)
OTHER_ID = Rule("RTC0518", "id is not that of the instance", Severity.WARNING)

RULES = rules_of(globals())
