"""Rules of systems on the target openrtm."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

SYSTEM_FOLDER = Rule("RTC0587", "system in the place of another one", Severity.ERROR)
LONELY_CONSUMER = Rule("RTC0588", "consumer without a provider", Severity.WARNING)
PER_CYCLE = Rule("RTC0589", "parameter of an unknown kind of execution", Severity.ERROR)
OWN_PORT = Rule("RTC0590", "connector that OpenRTM cannot have", Severity.WARNING)
INSTANCE_NAME = Rule(
    "RTC0591", "instance name that cannot be a file name", Severity.ERROR
)

RULES = rules_of(globals())
