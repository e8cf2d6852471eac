"""Names of structs and enums without a tag."""

from __future__ import annotations

from collections.abc import Iterable

from rtgen.compiler.frontends.cdl.syntax import tree

UNTAGGED = "untagged"
"""Name of a struct or enum without a tag, with which nothing is declared."""


def name_of_untagged(declarators: Iterable[tree.Declarator | None]) -> str:
    """Return the name of a struct or enum without a tag, from what is declared with it.

    It is that of the first declarator of the type itself, as in C++, else of the first one.
    """
    named = [(d, d.name.text) for d in declarators if d is not None and d.name]
    plain = (name for each, name in named if is_plain(each))
    return next(plain, named[0][1] if named else UNTAGGED)


def is_plain(declarator: tree.Declarator) -> bool:
    """Return whether what is declared has the type itself, not a pointer or array of it."""
    return not (
        declarator.pointers
        or declarator.suffixes
        or isinstance(declarator.inner, tree.Declarator)
    )
