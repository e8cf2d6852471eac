"""Limits chains of references between declarations, which later stages follow recursively."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.idl.rules.types import TOO_DEEP
from rtgen.compiler.kit.limits import MAX_LEVELS
from rtgen.compiler.model import Component, Declaration, ScopedName
from rtgen.compiler.model.graphs import groups
from rtgen.compiler.typemap.python.implementation_modules import referred


def checked(
    declarations: Mapping[ScopedName, Declaration], report: Callable[[Diagnostic], None]
) -> dict[ScopedName, Declaration]:
    """Return the declarations within MAX_LEVELS; reports the first chain that is deeper.

    Components beyond the limit are dropped, because each copies all inherited members.
    """
    if len(declarations) <= MAX_LEVELS:  # no chain is longer
        return dict(declarations)
    edges = {
        name: set(_parts(declaration)) for name, declaration in declarations.items()
    }
    levels: dict[ScopedName, int] = {}
    for group in groups(edges):
        below = max(
            (levels.get(part, 0) for name in group for part in edges[name]), default=0
        )
        level = below + len(group)
        levels.update(dict.fromkeys(group, level))
        if below <= MAX_LEVELS < level:
            first = declarations[min(group, key=lambda name: declarations[name].span)]
            message = (
                f"{first.scoped} leads from declaration to declaration for"
                f" {level} levels, more than {MAX_LEVELS}"
            )
            report(TOO_DEEP.at(first.span, message))
    return {
        name: declaration
        for name, declaration in declarations.items()
        if levels[name] <= MAX_LEVELS or not isinstance(declaration, Component)
    }


def _parts(declaration: Declaration) -> Iterator[ScopedName]:
    if isinstance(declaration, Component):
        yield from filter(None, (declaration.base, *declaration.supports))
    else:
        yield from referred(declaration)
