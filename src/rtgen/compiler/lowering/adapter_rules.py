"""Rules of adapters, `[adapter.NAME]` of rtgen.toml (codes ADP...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

ADAPTER_NAME = Rule("ADP0001", "adapter without a name of its own", Severity.ERROR)
ADAPTER_TYPE = Rule(
    "ADP0002", "adapter between types other than structs", Severity.ERROR
)
ADAPTER_MEMBER = Rule("ADP0003", "adapter with an unknown member", Severity.ERROR)
ADAPTER_VALUE = Rule("ADP0004", "members that do not fit", Severity.ERROR)
ADAPTER_UNIT = Rule("ADP0005", "members of different units", Severity.ERROR)

RULES = rules_of(globals())
