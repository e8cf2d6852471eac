"""A CDL file that was parsed, and the names that are types while the rest is parsed."""

from __future__ import annotations

from dataclasses import dataclass, field

from rtgen.diagnostics import Span
from rtgen.frontends.cdl.syntax import tree
from rtgen.frontends.cdl.text.source import Source
from rtgen.model.tecs import TecsDeclaration
from rtgen.model.types import ScopedName


@dataclass(frozen=True, slots=True)
class Header:
    """What a C header declares, in order."""

    declarations: tuple[TecsDeclaration, ...]


@dataclass(eq=False, slots=True)
class Unit:
    """A parsed file.

    `reused` says that it was imported by `<...>`. `imports` and `headers` hold what was read for
    an import; nothing for a file that was read before or is missing. `lost` are names that
    statements with syntax errors may have declared, `guessed` those that a missing C header may
    declare as types.
    """

    source: Source
    reused: bool = False
    items: tuple[tree.Item, ...] = ()
    imports: dict[tree.Import, Unit] = field(default_factory=dict)
    headers: dict[tree.ImportC, Header] = field(default_factory=dict)
    lost: set[str] = field(default_factory=set)
    guessed: set[str] = field(default_factory=set)

    def span(self, start: int, end: int) -> Span:
        """The place of [start, end) of the text."""
        return self.source.span(start, end)

    def place(self, node: tree.Name | tree.ScopedName | tree.Expression) -> Span:
        """The place of a node."""
        return self.source.span(node.start, node.end)


class TypeNames:
    """The names of typedefs by name space.

    `prelude` are names that are types only where nothing else can stand, until they are declared.
    """

    def __init__(self, prelude: frozenset[str]) -> None:
        self.prelude = prelude
        self.declared: dict[str, set[ScopedName]] = {}
        """The name spaces in which each name is declared."""

    def declare(self, space: ScopedName, name: str) -> None:
        """Note a typedef."""
        self.declared.setdefault(name, set()).add(space)

    def knows(self, space: ScopedName, name: str) -> bool:
        """Whether the name is a typedef, seen from a name space."""
        spaces = self.declared.get(name)
        return spaces is not None and any(
            space[:length] in spaces for length in range(len(space) + 1)
        )
