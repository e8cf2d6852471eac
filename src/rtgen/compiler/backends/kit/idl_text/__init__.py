"""Prints OMG IDL from a model; the IDL front end can read the result.

Only the content of the model is written: constants are evaluated, macros are gone. Homes are
omitted, and components unless requested, so that other IDL compilers can read the result; with
`annotations` they have to support IDL 4.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from rtgen.compiler.backends.kit.idl_text.scopes import ScopedNames
from rtgen.compiler.backends.kit.idl_text.writer import STEP, Writer
from rtgen.compiler.model import Declaration, Home, Model, ScopedName
from rtgen.compiler.model.components import Component
from rtgen.compiler.typemap.idl_keywords import escaped


def idl_text(
    model: Model,
    declarations: Iterable[Declaration],
    *,
    annotations: bool = True,
    components: bool = False,
    guard: Callable[[Declaration], str] = lambda declaration: "",
    escape: Callable[[str], str] = escaped,
) -> str:
    """Print declarations as IDL, opening and closing modules as necessary.

    Other declarations of the model are assumed to come from included files. `guard` returns the
    macro that protects a declaration contained in several files; empty for none. Nested
    declarations are printed with the enclosing one. `escape` returns the spelling of a name.
    """
    declarations = tuple(declarations)
    names = ScopedNames(model, declarations, escape)
    writer = Writer(model, annotations, names)
    parts: list[str] = []
    scope: ScopedName = ()
    for declaration in declarations:
        left_out = (Home,) if components else (Home, Component)
        if isinstance(declaration, left_out) or names.is_inner(declaration):
            continue
        macro = guard(declaration)
        path = declaration.name[:-1]
        if macro:
            parts += [*_to(scope, (), escape), f"#ifndef {macro}\n#define {macro}\n"]
            scope = ()
        parts += _to(scope, path, escape)
        scope = path
        parts += writer.top(declaration)
        if macro:
            parts += [*_to(scope, (), escape), f"#endif // {macro}\n"]
            scope = ()
    parts += _to(scope, (), escape)
    return "\n".join(parts)


def _to(
    scope: ScopedName, path: ScopedName, escape: Callable[[str], str]
) -> Iterator[str]:
    """Yield the lines between two modules."""
    common = 0
    while common < min(len(scope), len(path)) and scope[common] == path[common]:
        common += 1
    for depth in range(len(scope), common, -1):
        yield f"{STEP * (depth - 1)}}};\n"
    for depth in range(common, len(path)):
        yield f"{STEP * depth}module {escape(path[depth])} {{\n"
