"""Rules of the target openrtm (RTC0560 to RTC0589)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

RENAMED = Rule("RTC0560", "port has another name in OpenRTM", Severity.WARNING)
SAME_NAME = Rule("RTC0561", "two ports of one name in OpenRTM", Severity.ERROR)
TWO_NAMES = Rule("RTC0562", "service port with two names", Severity.ERROR)
PACKAGE = Rule("RTC0563", "package in the place of the modules", Severity.ERROR)
SAME_FOLDER = Rule("RTC0564", "two components with one folder", Severity.ERROR)
OTHER_PROFILE = Rule("RTC0565", "profile of another kind", Severity.WARNING)
HIDES = Rule("RTC0566", "module that hides another one", Severity.ERROR)
CONF_TEXT = Rule(
    "RTC0567", "text that a configuration file cannot hold", Severity.ERROR
)
NOT_CLASSIC = Rule("RTC0570", "type that OpenRTM cannot have", Severity.ERROR)
PYTHON_MODULE = Rule(
    "RTC0571", "IDL module with the name of one of Python's", Severity.WARNING
)
PROJECT_MODULE = Rule(
    "RTC0572", "IDL module with the name of one of the project's", Severity.ERROR
)

RULES = rules_of(globals())
