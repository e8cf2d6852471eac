"""The rules of characters in files of definitions (codes TXT...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

ENCODING = Rule("TXT0001", "doubtful encoding", Severity.WARNING)
OCTET_OF_COMMENT = Rule(
    "TXT0002", "comment that ends in the octet of a backslash", Severity.WARNING
)
CONTINUED_COMMENT = Rule("TXT0003", "comment continued in the next line", Severity.NOTE)
LONE_RETURN = Rule("TXT0004", "carriage return without a line feed", Severity.WARNING)
OCTET_OF_LITERAL = Rule(
    "TXT0005", "literal with the octet of a backslash", Severity.WARNING
)

RULES = rules_of(globals())
