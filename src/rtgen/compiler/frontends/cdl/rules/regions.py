"""Rules of regions and of plug-ins on joins (CDL07xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

SPECIFIERS_AGAIN = Rule(
    "CDL0700", "specifiers where a region is opened again", Severity.ERROR
)
NAME_OF_ANOTHER = Rule(
    "CDL0701", "name of a region or name space taken", Severity.ERROR
)
GOING_OUT = Rule("CDL0702", "join out of a region", Severity.ERROR)
GOING_TO = Rule("CDL0703", "join between regions", Severity.ERROR)
GOING_IN = Rule("CDL0704", "join into a region", Severity.ERROR)
LINK_UNITS = Rule("CDL0705", "join between link units", Severity.ERROR)
KIND_TWICE = Rule("CDL0706", "two kinds of one region", Severity.ERROR)
UNKNOWN_PLUGIN = Rule("CDL0710", "unknown plug-in", Severity.WARNING)
THROUGH_ATTRIBUTE = Rule(
    "CDL0711", "through before something that is not a join", Severity.WARNING
)
THROUGH_IGNORED = Rule("CDL0712", "through without effect", Severity.WARNING)
BAD_ARGUMENT = Rule("CDL0713", "malformed argument of a plug-in", Severity.ERROR)
OPTION_TWICE = Rule("CDL0714", "option given twice", Severity.WARNING)
UNKNOWN_SUBSTITUTION = Rule("CDL0715", "unknown word between dollars", Severity.ERROR)
MISSPELT_PLUGIN = Rule("CDL0716", "misspelt plug-in", Severity.ERROR)

RULES = rules_of(globals())
