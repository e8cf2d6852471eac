"""Rules about files and imports (CDL00xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_FILE = Rule("CDL0001", "file not found", Severity.ERROR)
UNREADABLE = Rule("CDL0002", "file cannot be read", Severity.ERROR)
BINARY = Rule("CDL0003", "not a text file", Severity.ERROR)
TOO_LARGE = Rule("CDL0004", "file too large", Severity.ERROR)
ENCODING = Rule("CDL0005", "doubtful encoding", Severity.WARNING)
IMPORT_MISSING = Rule("CDL0006", "imported file not found", Severity.ERROR)
KERNEL_MISSING = Rule("CDL0007", "kernel file not found", Severity.WARNING)
IMPORT_FORM = Rule("CDL0008", "file imported in both forms", Severity.WARNING)
PRELUDE = Rule("CDL0009", "kernel types known without an import", Severity.NOTE)
TOO_MANY = Rule("CDL0010", "too many findings", Severity.ERROR)
SAME_STEM = Rule("CDL0011", "two CDL files of one name", Severity.ERROR)
IMPORT_DEPTH = Rule("CDL0012", "imports nested too deeply", Severity.ERROR)

RULES = rules_of(globals())
