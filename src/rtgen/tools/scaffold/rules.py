"""The rules of `rtgen new` (codes NEW...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

UNUSABLE_NAME = Rule("NEW0001", "name that cannot be used", Severity.ERROR)
EXISTS = Rule("NEW0002", "file that exists already", Severity.ERROR)
NO_PROJECT = Rule("NEW0003", "no project to add to", Severity.ERROR)
NO_COMPONENT = Rule("NEW0004", "system without such a component", Severity.ERROR)
NO_TEMPLATES = Rule("NEW0005", "no folder for templates", Severity.ERROR)
NO_DRIVE = Rule("NEW0006", "drive that a base cannot use", Severity.ERROR)
NO_SYSTEM = Rule("NEW0007", "package without a system to launch", Severity.ERROR)
CIRCLE = Rule("NEW0008", "packages that need each other", Severity.ERROR)
OUTSIDE = Rule("NEW0009", "file that no package can have", Severity.ERROR)

RULES = rules_of(globals())
