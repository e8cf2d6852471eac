"""Rules of OpenRTM-aist-Python modules (RTC0550 and following)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNREADABLE = Rule("RTC0550", "not a module of Python", Severity.ERROR)
NO_COMPONENT = Rule("RTC0551", "no component", Severity.ERROR)
COMPUTED = Rule("RTC0552", "known only when the module runs", Severity.WARNING)
NOT_ADDED = Rule("RTC0553", "port that is never added", Severity.WARNING)
NOT_CARRIED = Rule("RTC0554", "not supported by definitions", Severity.WARNING)
BEHAVIOUR = Rule("RTC0555", "behaviour to be moved by hand", Severity.NOTE)
ASSUMED = Rule(
    "RTC0556", "module in another encoding or Python version", Severity.WARNING
)

RULES = rules_of(globals())
