"""Rules of files, lines, sections and keys (EDS00xx, EDS01xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_FILE = Rule("EDS0001", "file not found", Severity.ERROR)
UNREADABLE = Rule("EDS0002", "file cannot be read", Severity.ERROR)
BINARY = Rule("EDS0003", "not a text file", Severity.ERROR)
TOO_LARGE = Rule("EDS0004", "file too large", Severity.ERROR)
NOT_ASCII = Rule("EDS0005", "not ASCII", Severity.WARNING)
A_LINK = Rule("EDS0006", "path instead of a description", Severity.ERROR)
NO_DEVICE = Rule("EDS0007", "no device description", Severity.ERROR)
TOO_MANY_OBJECTS = Rule("EDS0008", "too many sub-objects", Severity.ERROR)
TOO_MANY_FINDINGS = Rule("EDS0009", "too many findings", Severity.WARNING)
STRAY_LINE = Rule("EDS0100", "line that is neither section nor key", Severity.WARNING)
OUTSIDE = Rule("EDS0101", "key outside of sections", Severity.WARNING)
BAD_HEADER = Rule("EDS0102", "malformed section header", Severity.WARNING)
SAME_SECTION = Rule("EDS0103", "section given twice", Severity.WARNING)
SAME_KEY = Rule("EDS0104", "key given twice", Severity.WARNING)
STRAY_COMMENT = Rule("EDS0105", "comment where none is allowed", Severity.WARNING)
OTHER_SPELLING = Rule("EDS0106", "section spelt in another way", Severity.WARNING)
UNKNOWN_SECTION = Rule("EDS0107", "unknown section", Severity.NOTE)
UNKNOWN_KEY = Rule("EDS0108", "unknown key", Severity.NOTE)
MISSPELT_KEY = Rule("EDS0109", "misspelt key", Severity.WARNING)
COLON = Rule("EDS0110", "colon in place of the equals sign", Severity.WARNING)

MISSPELT_SECTION = Rule("EDS0111", "misspelt section", Severity.WARNING)

RULES = rules_of(globals())
