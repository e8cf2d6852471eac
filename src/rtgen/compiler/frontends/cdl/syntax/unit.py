"""A parsed CDL file, and the table of typedef names during parsing."""

from __future__ import annotations

from dataclasses import dataclass, field

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.cdl.syntax import statements
from rtgen.compiler.frontends.cdl.text.source import Source
from rtgen.compiler.model.tecs import TecsDeclaration
from rtgen.compiler.model.types import ScopedName


@dataclass(frozen=True, slots=True)
class Header:
    """A C header with its declarations, in order."""

    declarations: tuple[TecsDeclaration, ...]


@dataclass(eq=False, slots=True)
class Unit:
    """A parsed file.

    `reused`: imported by `<...>`. `imports` and `headers` map import statements to the files
    read for them, except missing files and those read before. `skipped`: a statement with a syntax
    error is not in `items`. `maybe_declared` are names that such statements may have declared,
    `guessed` those that a missing C header may declare as types.
    """

    source: Source
    reused: bool = False
    items: tuple[statements.Item, ...] = ()
    imports: dict[statements.Import, Unit] = field(default_factory=dict)
    headers: dict[statements.ImportC, Header] = field(default_factory=dict)
    skipped: bool = False
    maybe_declared: set[str] = field(default_factory=set)
    guessed: set[str] = field(default_factory=set)

    def span(self, start: int, end: int) -> Span:
        """Return the span of [start, end) of the text."""
        return self.source.span(start, end)


class TypeNames:
    """The names of typedefs by name space.

    `prelude` are names that denote types, until declared, only where the grammar requires a type.
    """

    def __init__(self, prelude: frozenset[str]) -> None:
        self.prelude = prelude
        self.declared: dict[str, set[ScopedName]] = {}
        """The name spaces that declare each name."""

    def declare(self, space: ScopedName, name: str) -> None:
        """Record a typedef."""
        self.declared.setdefault(name, set()).add(space)

    def knows(self, space: ScopedName, name: str) -> bool:
        """Return whether the name is a typedef visible in a name space."""
        spaces = self.declared.get(name)
        return spaces is not None and any(
            space[:length] in spaces for length in range(len(space) + 1)
        )
