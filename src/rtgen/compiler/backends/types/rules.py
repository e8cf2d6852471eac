"""The rules of Python types and CDR: restrictions on what can be emitted."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_MARSHALLED = Rule("PY0001", "Type without a CDR codec", Severity.ERROR)
NOT_IN_XCDR = Rule("PY0003", "Type unknown to DDS", Severity.ERROR)
LONG_NAME = Rule("PY0002", "Name too long for a folder", Severity.ERROR)

RULES = rules_of(globals())
"""All rules, by code."""
