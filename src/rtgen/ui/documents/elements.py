"""Elements of a profile that can be changed; those of a file know their place in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from rtgen.compiler.model.profile_elements import RTS, Name, ProfileElement


@dataclass(slots=True, eq=False)
class Place:
    """The offsets of an element in the text: its tags `[start, head)` and `[tail, end)`.

    An empty-element tag has no end tag: `head`, `tail` and `end` are equal. `attributes` has the
    offsets of the values, between the quotes; `prefixes` are those in scope, with their namespaces.
    """

    start: int
    head: int
    tail: int
    end: int
    tag: str
    attributes: Mapping[Name, tuple[int, int]]
    prefixes: Mapping[str, str]
    children: list[Place] = field(default_factory=list)

    @property
    def is_empty(self) -> bool:
        """Whether the element is an empty-element tag."""
        return self.head == self.end


@dataclass(slots=True, eq=False)
class Editable:
    """An element; `place` is None if the file does not have it."""

    name: Name
    attributes: dict[Name, str]
    children: list[Editable] = field(default_factory=list)
    text: str = ""
    place: Place | None = None

    def get(self, local_name: str, namespace: str = RTS) -> str:
        """Return an attribute's value, empty if it is missing."""
        return self.attributes.get((namespace, local_name), "")

    def all(self, local_name: str) -> Iterator[Editable]:
        """Return the children of that local name, in order."""
        return (child for child in self.children if child.name[1] == local_name)

    def first(self, local_name: str) -> Editable | None:
        """Return the first child of that local name."""
        return next(self.all(local_name), None)

    def insert(self, child: Editable, position: Callable[[Name], int]) -> None:
        """Insert a child behind the last one whose name has no later position."""
        own = position(child.name)
        index = len(self.children)
        while index and position(self.children[index - 1].name) > own:
            index -= 1
        self.children.insert(index, child)


def editable(element: ProfileElement) -> Editable:
    """Return an element that the file does not have."""
    return Editable(
        element.name,
        dict(element.attributes),
        [*map(editable, element.children)],
        element.text,
    )
