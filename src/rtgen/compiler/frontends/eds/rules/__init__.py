"""Rules of the EDS front end, in modules by hundreds of their codes."""

from rtgen.compiler.diagnostics import Rule, Severity
from rtgen.compiler.frontends.eds.rules import (
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

_ABOUT_SERVICES = (
    values.BAD_COB_ID,
    pdos.BAD_COB_ID,
    pdos.NO_NODE_ID,
    pdos.MULTIPLEXED,
)
DEVIATIONS = frozenset(
    rule.code
    for rule in RULES
    if rule.severity is not Severity.ERROR and rule not in _ABOUT_SERVICES
)
"""Codes of deviations from CiA 306 and CiA 301 that are tolerated: no service gets another
identifier for them, or is switched off.
"""
