"""The rules of reading XML."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MALFORMED = Rule("RTC0501", "not well-formed XML", Severity.ERROR)
DOCTYPE = Rule("RTC0502", "document type declaration", Severity.ERROR)
ENCODING = Rule("RTC0503", "bytes do not fit the encoding", Severity.ERROR)
DEPTH = Rule("RTC0504", "elements nested too deeply", Severity.ERROR)

RULES = rules_of(globals())
