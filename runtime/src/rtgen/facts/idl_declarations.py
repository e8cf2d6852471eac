"""What an IDL text likely declares, without reading it as a front end does: for searches."""

from __future__ import annotations

import re
from typing import Final, NamedTuple

_DECLARED: Final = re.compile(
    r"\b(module|struct|union|interface)\s+(\w+)\s*(?:[{:]|switch\b)"
)


class Declared(NamedTuple):
    """The types and interfaces of a text, and its modules, by their own names."""

    types: frozenset[str]
    modules: frozenset[str]

    def has(self, scoped: str) -> bool:
        """Return whether the text likely declares a type, whose name may lack its scope."""
        *scope, name = re.split(r"::|[./]", scoped)
        return name in self.types and self.modules.issuperset(filter(None, scope))


def declared(text: str) -> Declared:
    """Return what a text likely declares, including what its comments seem to."""
    declarations = [match.groups() for match in _DECLARED.finditer(text)]
    return Declared(
        frozenset(name for kind, name in declarations if kind != "module"),
        frozenset(name for kind, name in declarations if kind == "module"),
    )
