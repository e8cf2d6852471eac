"""The rules of the IDL front end, grouped by hundreds as the codes are."""

from rtgen.diagnostics import Rule
from rtgen.frontends.idl.rules import (
    annotations,
    constants,
    interfaces,
    lexical,
    names,
    repository,
    syntax,
    types,
)

RULES: tuple[Rule, ...] = (
    *lexical.RULES,
    *syntax.RULES,
    *names.RULES,
    *types.RULES,
    *constants.RULES,
    *interfaces.RULES,
    *repository.RULES,
    *annotations.RULES,
)
