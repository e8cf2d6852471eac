"""Changes that all declarations have: items that come, go or get another name, and values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from rtgen.compiler.diagnostics import Span
from rtgen.tools.diff.changes import Change, Kind, change
from rtgen.tools.diff.matching import Matching

Spans = tuple[Span | None, Span | None]


class _Placed(Protocol):
    @property
    def span(self) -> Span: ...


Item = TypeVar("Item", bound=_Placed)
NOWHERE: Spans = (None, None)


@dataclass(frozen=True, slots=True)
class Group:
    """Items of one sort: their word in messages, and the kinds of their changes."""

    word: str
    added: Kind
    removed: Kind
    renamed: Kind | None = None


def item_changes(
    group: Group,
    found: Matching[Any, Item],
    name: Callable[[Item], str],
    owners: Spans = NOWHERE,
    *,
    old_name: Callable[[Item], str] | None = None,
    label: Callable[[Item], str] | None = None,
) -> Iterator[Change]:
    """Yield a change for each item in one version only, or with another name.

    `owners` are the places of what has the items, in both versions. `old_name` is the subject of
    an old item, if `name` gives that of a new one only; `label` its name without that of its owner.
    """
    subject = old_name or name
    for item in found.removed:
        text = f"{group.word} {subject(item)} is removed"
        yield change(group.removed, subject(item), text, item.span, owners[1])
    for item in found.added:
        text = f"{group.word} {name(item)} is added"
        yield change(group.added, name(item), text, owners[0], item.span)
    if group.renamed is None:
        return
    for one, other in found.renamed:
        text = f"{group.word} {name(other)} was called {(label or subject)(one)}"
        yield change(group.renamed, name(other), text, one.span, other.span)


@dataclass(frozen=True, slots=True)
class Fact:
    """A fact of a declaration: the kind of its change, its word in messages, and its value."""

    kind: Kind
    word: str
    value: Callable[[Any], object]


def fact_changes(
    facts: Iterable[Fact],
    old: Any,
    new: Any,
    subject: str,
    spans: Spans,
    word: str = "",
) -> Iterator[Change]:
    """Yield a change for each fact that is another one; `word` precedes the subject in messages."""
    name = f"{word} {subject}" if word else subject
    for fact in facts:
        before, after = fact.value(old), fact.value(new)
        if before != after:
            text = f"{name} has the {fact.word} {after}, had {before}"
            yield change(fact.kind, subject, text, *spans)
