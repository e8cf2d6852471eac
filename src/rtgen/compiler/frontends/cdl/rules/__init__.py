"""Rules of the CDL front end, in modules by hundreds of their codes."""

from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.frontends.cdl.rules import (
    cells,
    celltypes,
    constants,
    files,
    headers,
    lexical,
    regions,
    signatures,
    syntax,
    types,
)

RULES: tuple[Rule, ...] = (
    *files.RULES,
    *lexical.RULES,
    *syntax.RULES,
    *types.RULES,
    *signatures.RULES,
    *celltypes.RULES,
    *cells.RULES,
    *regions.RULES,
    *constants.RULES,
    *headers.RULES,
)
