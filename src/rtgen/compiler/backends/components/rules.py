"""The rules about components: restrictions on what can be emitted."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NAME = Rule("RTC0101", "component name cannot be used", Severity.ERROR)
SAME_MODULE = Rule("RTC0102", "two components with one package", Severity.ERROR)
VERSION = Rule("RTC0103", "version cannot be used", Severity.ERROR)
DATE = Rule("RTC0104", "date is not an xsd:dateTime", Severity.ERROR)
CHOICE = Rule("RTC0105", "unknown activity or component type", Severity.ERROR)
ID_PART = Rule("RTC0106", "text would break the profile's id", Severity.ERROR)
NUMBER = Rule("RTC0107", "bad rate or number of instances", Severity.ERROR)
TEXT = Rule("RTC0108", "text that XML cannot hold", Severity.ERROR)
SHADOWS = Rule("RTC0109", "skeleton that hides a module of Python", Severity.ERROR)
MISSPELT_KIND = Rule("RTC0110", "misspelt kind of a component", Severity.WARNING)
SAME_PORT = Rule("RTC0201", "two ports of one direction and name", Severity.ERROR)
DATA_TYPE = Rule("RTC0202", "data port without a struct or union", Severity.ERROR)
INTERFACE = Rule("RTC0203", "service port without an interface", Severity.ERROR)
SAME_INTERFACE = Rule("RTC0204", "interface twice in a port", Severity.ERROR)
SAME_PARAMETER = Rule("RTC0301", "two parameters of one name", Severity.ERROR)
PARAMETER_TYPE = Rule("RTC0302", "type cannot be a parameter", Severity.ERROR)
DEFAULT_TYPE = Rule("RTC0303", "default does not fit the type", Severity.ERROR)
DEFAULT_RANGE = Rule("RTC0304", "default is not allowed", Severity.ERROR)
BOUNDS = Rule("RTC0305", "bad bounds", Severity.ERROR)
CONSTRAINT = Rule("RTC0306", "constraint cannot be read", Severity.ERROR)
WIDGET = Rule("RTC0307", "unknown widget", Severity.ERROR)
WIDGET_NEEDS = Rule("RTC0308", "widget without bounds or values", Severity.WARNING)

RULES = rules_of(globals())
