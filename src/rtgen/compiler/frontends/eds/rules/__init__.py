"""Rules of the EDS front end, in modules by hundreds of their codes."""

from rtgen.compiler.diagnostics import Rule, Severity
from rtgen.compiler.frontends.eds.rules import (
    information,
    lexical,
    modules,
    objects,
    pdos,
    values,
    xml,
)

RULES: tuple[Rule, ...] = (
    *lexical.RULES,
    *information.RULES,
    *objects.RULES,
    *values.RULES,
    *pdos.RULES,
    *modules.RULES,
    *xml.RULES,
)

_ABOUT_SERVICES = (
    values.BAD_COB_ID,
    pdos.BAD_COB_ID,
    pdos.NO_NODE_ID,
    pdos.MULTIPLEXED,
)
LOSSES = tuple(
    rule.code
    for rule in (
        lexical.MISSPELT_SECTION,
        lexical.BAD_HEADER,
        information.NOT_THERE,
        objects.UNKNOWN_TYPE,
        objects.UNKNOWN_ACCESS,
        objects.OF_A_VAR,
        objects.BAD_SUBINDEX,
        pdos.NO_OBJECT,
    )
)
"""Codes of deviations by which a part of a device is lost or means something else; causes first."""
DEVIATIONS = frozenset(
    rule.code
    for rule in RULES
    if rule.severity is not Severity.ERROR and rule not in _ABOUT_SERVICES
)
"""Codes of deviations from CiA 306 and CiA 301 that are tolerated: no service gets another
identifier for them, or is switched off.
"""
