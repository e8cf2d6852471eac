"""Name spaces and regions with what is declared in them.

A struct tag is known by its tag alone: tags have name spaces of their own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from rtgen.diagnostics import Span
from rtgen.model.types import ScopedName


@dataclass(eq=False, slots=True)
class Entity:
    """Something with a name in a space.

    `kind` is the word for messages: `signature`, `celltype`, `composite`, `cell`, `typedef`,
    `constant`, `namespace`, `region`, `struct`, `enum`. `value` is what the pass that declared it
    knows of it; None where it is broken, and its mistake told.
    """

    kind: str
    name: str
    space: Space
    span: Span
    value: object = None

    @property
    def path(self) -> ScopedName:
        """The name from the root down."""
        return (*self.space.path, self.name)


@dataclass(eq=False, slots=True)
class Space:
    """A name space or, as `region` says, a region; the root is both, and has no name."""

    name: str = ""
    outer: Space | None = None
    region: bool = True
    names: dict[str, Entity] = field(default_factory=dict)
    tags: dict[str, Entity] = field(default_factory=dict)

    @property
    def path(self) -> ScopedName:
        """The name from the root down; nothing for the root."""
        return () if self.outer is None else (*self.outer.path, self.name)

    @property
    def line(self) -> Iterator[Space]:
        """This space and those around it, outwards."""
        space: Space | None = self
        while space is not None:
            yield space
            space = space.outer

    def find(self, name: str) -> Entity | None:
        """What a plain name stands for here: looked for from here outwards."""
        for space in self.line:
            if name in space.names:
                return space.names[name]
        return None

    def find_tag(self, tag: str) -> Entity | None:
        """What a struct's tag stands for here."""
        for space in self.line:
            if tag in space.tags:
                return space.tags[tag]
        return None

    def lookup(self, parts: Sequence[str], absolute: bool = False) -> Entity | None:
        """What `a`, `a::b` or `::a::b` stands for here; None if any part of it is unknown."""
        first, *rest = parts
        if absolute:
            *_, root = self.line
            found = root.names.get(first)
        else:
            found = self.find(first)
        for part in rest:
            inner = found.value if found is not None else None
            found = inner.names.get(part) if isinstance(inner, Space) else None
        return found

    def visible(self, kinds: frozenset[str]) -> Iterator[str]:
        """The plain names of those kinds that can be used here."""
        for space in self.line:
            yield from (n for n, e in space.names.items() if e.kind in kinds)
