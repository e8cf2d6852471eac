"""Rules of the EDS front end, in modules by hundreds of their codes."""

from rtgen.diagnostics import Rule
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
