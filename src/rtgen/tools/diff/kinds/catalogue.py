"""All kinds of changes, and the rules of the command itself."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity
from rtgen.tools.diff.changes import Kind
from rtgen.tools.diff.kinds import (
    components,
    devices,
    interfaces,
    signatures,
    systems,
    types,
)

NO_VERSION = Rule("DIF0001", "no such version", Severity.ERROR)
GIT_FAILED = Rule("DIF0002", "git cannot read the revision", Severity.ERROR)
TOO_LARGE = Rule("DIF0003", "revision too large", Severity.ERROR)
UNUSED_ALLOWANCE = Rule(
    "DIF0004", "allowed break that does not occur", Severity.WARNING
)

KINDS: tuple[Kind, ...] = (
    *types.KINDS,
    *interfaces.KINDS,
    *components.KINDS,
    *signatures.KINDS,
    *devices.KINDS,
    *systems.KINDS,
)
"""Every kind of change, by code."""

RULES: tuple[Rule, ...] = (
    NO_VERSION,
    GIT_FAILED,
    TOO_LARGE,
    UNUSED_ALLOWANCE,
    *(kind.rule for kind in KINDS),
)
