"""The rules of the CANopen back end (EDS0805)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_WRITABLE = Rule("EDS0805", "value that cannot be written to a node", Severity.ERROR)

RULES = rules_of(globals())
