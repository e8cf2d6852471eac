"""Rules of the IDL front end, in modules by hundreds of their codes."""

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.idl.rules import (
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
