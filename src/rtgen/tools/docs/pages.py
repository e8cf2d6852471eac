"""A page under construction, and helpers shared by all pages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

from rtgen.compiler.backends.kit.quoting.markdown import (
    Markdown,
    code,
    paragraphs,
    table,
    text,
)
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.layouts.offsets import Layouts
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import Component, Extensibility, Model, PortKind, System
from rtgen.facts.comments import first_sentence
from rtgen.tools.docs.places import Kind, Places

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class File:
    """A file of the site: its path in the folder, and its text."""

    path: str
    text: str


@dataclass(frozen=True)
class Content:
    """The documented content: a model after all lowerings, its systems, and default encodings."""

    title: str
    model: Model
    systems: tuple[System, ...]
    places: Places
    keys: dict[str, str]
    xcdr2: bool
    extensibility: Extensibility

    @cached_property
    def cdr(self) -> Representations:
        """The representations of types; those without annotation are CDR."""
        return Representations(self.model, False, self.extensibility)

    @cached_property
    def layouts(self) -> tuple[Layouts, Layouts]:
        """The layouts of structs; those without annotation are CDR, or XCDR2."""
        xcdr2 = Representations(self.model, True, self.extensibility)
        return Layouts(self.model, self.cdr), Layouts(self.model, xcdr2)

    @cached_property
    def users(self) -> dict[tuple[PortKind, str], list[str]]:
        """The components by the kind and the type of their ports."""
        users: dict[tuple[PortKind, str], list[str]] = {}
        for each in self.model.declarations:
            if isinstance(each, Component):
                for key in {(p.kind, str(p.type)): None for p in each.ports}:
                    users.setdefault(key, []).append(each.name[-1])
        return users

    def assign(self, kind: Kind, items: Mapping[str, Item]) -> Mapping[str, Item]:
        """Assign a page to each item; return the items."""
        for name in items:
            self.places.page(kind, name)
        return items

    def pages(
        self,
        kind: Kind,
        items: Mapping[str, Item],
        add: Callable[[Content, Page, Item], None],
    ) -> Iterator[tuple[str, Page]]:
        """Yield the name and the page of each item; `add` fills it."""
        for name, item in items.items():
            page = Page(self.places.page(kind, name), name)
            add(self, page, item)
            yield name, page

    def source(self, file: str, span: Span) -> Markdown:
        """Return the file and line of a definition, relative to the project."""
        return code(f"{self.keys.get(file, file)}:{span.line}")


def counted(words: Iterable[str]) -> str:
    """Return the number of each word, such as `3 structs, 1 enum`, in the order of the words."""
    numbers = Counter(words)
    return ", ".join(
        f"{number} {word}{'s' * (number > 1)}" for word, number in numbers.items()
    )


@dataclass(slots=True)
class Page:
    """The lines of a page; `path` is without suffix, `summary` one line for the index."""

    path: str
    title: str
    summary: str = ""
    blocks: list[str] = field(default_factory=list)

    def add(self, *blocks: str) -> None:
        """Append blocks, except empty ones."""
        self.blocks += [block for block in blocks if block]

    def heading(self, level: int, label: object, anchor: str = "") -> None:
        """Append a heading."""
        end = f" {{#{anchor}}}" if anchor else ""
        self.blocks.append(f"{'#' * level} {text(label)}{end}")

    def description(self, value: str) -> None:
        """Append a description, of which the first sentence is the summary of the page."""
        self.summary = self.summary or first_sentence(value)
        self.add(paragraphs(value))

    def table(self, head: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
        """Append a table, if it has rows."""
        self.add(table(head, rows))

    @property
    def file(self) -> File:
        """The page as a file."""
        body = "\n\n".join([f"# {text(self.title)}", *self.blocks])
        return File(f"{self.path}.md", f"{body}\n")
