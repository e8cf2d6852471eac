"""The rules of components and connections of a system."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

DIMENSIONS_DIFFER = Rule("RTC0593", "ports of different dimensions", Severity.ERROR)
UNIT_MISSING = Rule("RTC0594", "unit at one end of a connector only", Severity.NOTE)
SCALES_DIFFER = Rule("RTC0595", "ports of different scales", Severity.WARNING)
MAY_DIFFER = Rule("RTC0596", "units that may not fit", Severity.WARNING)

UNITS = rules_of(globals())
"""The rules of the units of two ports."""

UNKNOWN_PORT = Rule(
    "RTC0581", "connector with a port that is not there", Severity.ERROR
)
PORTS_DIFFER = Rule("RTC0582", "ports that cannot be joined", Severity.ERROR)
UNKNOWN_PROPERTY = Rule("RTC0583", "unknown connector property", Severity.ERROR)
PROPERTY_VALUE = Rule(
    "RTC0584", "connector property with a value that it does not take", Severity.ERROR
)
DATA_TYPE = Rule(
    "RTC0585", "connector declares another type than its ports", Severity.WARNING
)
ALLOWED_IN_VAIN = Rule(
    "RTC0597", "connector that allows what it does not have", Severity.WARNING
)
TWICE = Rule("RTC0519", "ports joined twice", Severity.ERROR)
UNSERVED = Rule("RTC0598", "consumer without a provider", Severity.WARNING)

CONNECTIONS = rules_of(globals())
"""The rules of connections, with those of units."""

UNKNOWN_COMPONENT = Rule(
    "RTC0580", "system with a component that is not defined", Severity.ERROR
)
SYSTEM_PARAMETER = Rule(
    "RTC0586",
    "configuration that the component's definition does not have",
    Severity.ERROR,
)
CONFIGURED_IN_VAIN = Rule(
    "RTC0599", "configuration that a run refuses", Severity.WARNING
)
OTHER_DEFINITION = Rule("RTC0592", "id is not that of the definition", Severity.WARNING)

RULES = rules_of(globals())
