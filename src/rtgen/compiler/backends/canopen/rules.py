"""The rules of the CANopen back end (EDS0805, EDS0808, EDS0809)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_WRITABLE = Rule("EDS0805", "value that cannot be written to a node", Severity.ERROR)
NOT_IN_DBC = Rule("EDS0808", "what a DBC file cannot say", Severity.WARNING)
CHANGED = Rule("EDS0809", "changed in the written description", Severity.NOTE)

RULES = rules_of(globals())
