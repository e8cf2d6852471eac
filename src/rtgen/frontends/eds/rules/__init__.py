"""Rules of the EDS front end, in modules by hundreds of their codes."""

from rtgen.diagnostics import Rule, Severity
from rtgen.frontends.eds.rules import (
    information,
    lexical,
    modules,
    objects,
    pdos,
    values,
)

RULES: tuple[Rule, ...] = (
    *lexical.RULES,
    *information.RULES,
    *objects.RULES,
    *values.RULES,
    *pdos.RULES,
    *modules.RULES,
)

DEVIATIONS = frozenset(
    rule.code for rule in RULES if rule.severity is not Severity.ERROR
)
"""Codes of deviations from CiA 306 and CiA 301 with which a description is read."""
