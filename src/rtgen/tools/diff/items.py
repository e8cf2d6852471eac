"""Changes that all declarations have: items that come, go or get another name, and values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Protocol, TypeVar

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.matching import Matching
from rtgen.tools.diff.changes import Change, Kind, change

Spans = tuple[Span | None, Span | None]


class _Placed(Protocol):
    @property
    def span(self) -> Span: ...


class Scoped(_Placed, Protocol):
    """A declaration with its name."""

    @property
    def scoped(self) -> str: ...


Item = TypeVar("Item", bound=_Placed)
Key = TypeVar("Key")
NOWHERE: Spans = (None, None)


@dataclass(frozen=True, slots=True)
class Group:
    """Items of one sort: their word in messages, and the kinds of their changes.

    `word` and `added` may depend on the item.
    """

    word: str | Callable[[Any], str]
    added: Kind | Callable[[Any], Kind]
    removed: Kind
    renamed: Kind | None = None


def _chosen(choice: Any, *items: object) -> Any:
    return choice(*items) if callable(choice) else choice


def item_changes(
    group: Group,
    found: Matching[Any, Item],
    name: Callable[[Item], str],
    owners: Spans = NOWHERE,
    *,
    old_name: Callable[[Item], str] | None = None,
    label: Callable[[Item], str] | None = None,
    place: Callable[[Item], Span] = attrgetter("span"),
) -> Iterator[Change]:
    """Yield a change for each item in one version only, or with another name.

    `owners` are the places of what has the items, in both versions. `old_name` is the subject of
    an old item, if `name` gives that of a new one only; `label` its name without that of its owner.
    """
    subject = old_name or name
    for item in found.removed:
        text = f"{_chosen(group.word, item)} {subject(item)} is removed".lstrip()
        yield change(group.removed, subject(item), text, place(item), owners[1])
    for item in found.added:
        text = f"{_chosen(group.word, item)} {name(item)} is added".lstrip()
        kind = _chosen(group.added, item)
        yield change(kind, name(item), text, owners[0], place(item))
    if group.renamed is None:
        return
    for one, other in found.renamed:
        word = _chosen(group.word, other)
        text = f"{word} {name(other)} was called {(label or subject)(one)}"
        yield change(group.renamed, name(other), text, place(one), place(other))


def part_items(
    group: Group, found: Matching[Any, Any], old: Scoped, new: Scoped
) -> Iterator[Change]:
    """Yield the same changes of the named parts of a declaration."""
    yield from item_changes(
        group,
        found,
        lambda part: f"{new.scoped}.{part.name}",
        (old.span, new.span),
        old_name=lambda part: f"{old.scoped}.{part.name}",
        label=attrgetter("name"),
    )


@dataclass(frozen=True, slots=True)
class Fact:
    """A fact of a declaration: the kind of its change, its word in messages, and its value.

    `kind` may depend on the old and the new value. `word` is a noun, or the message: `{name}` has
    the value `{now}`, which was `{was}`; `{no}` is `no longer ` for a value that is false now.
    """

    kind: Kind | Callable[[Any, Any], Kind]
    word: str
    value: Callable[[Any], object]
    shown: Callable[[Any], object] = str


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
            text = fact.word
            if "{" not in text:
                text = f"{{name}} has the {text} {{now}}, had {{was}}"
            now, was, no = (
                fact.shown(after),
                fact.shown(before),
                "no longer " * (not after),
            )
            text = text.format(name=name, now=now, was=was, no=no)
            yield change(_chosen(fact.kind, before, after), subject, text, *spans)


def part_changes(
    group: Group,
    reordered: Kind,
    old: Mapping[str, Any],
    new: Mapping[str, Any],
    owner: str,
    owners: tuple[Span, Span],
) -> Iterator[Change]:
    """Yield a change of `owner` for each parameter that it lost or got, and for their order.

    The keys are the new names, if only a name is another one.
    """
    for key, part in old.items():
        if key not in new:
            text = f"{group.word} {part.name} of {owner} is removed"
            yield change(group.removed, owner, text, part.span, owners[1])
    for key, part in new.items():
        if key not in old:
            text = f"{group.word} {key} of {owner} is added"
            yield change(_chosen(group.added, part), owner, text, owners[0], part.span)
    if is_reordered([*old], [*new]):
        text = f"the {group.word}s of {owner} are in another order"
        yield change(reordered, owner, text, *owners)


def is_reordered(old: Sequence[str], new: Sequence[str]) -> bool:
    """Return whether the common items are in another order."""
    return [n for n in old if n in new] != [n for n in new if n in old]


def by_name(items: Iterable[Any]) -> dict[str, Any]:
    """Return the items by their names."""
    return {item.name: item for item in items}


def differing(
    old: Mapping[Key, object], new: Mapping[Key, object]
) -> Iterator[tuple[Key, Any, Any]]:
    """Yield each key with another value: the key, the old and the new value, None for none."""
    for key in dict.fromkeys((*old, *new)):
        if old.get(key) != new.get(key):
            yield key, old.get(key), new.get(key)


def start_of(item: Any) -> Span:
    """Return the start of the file of a system or bus."""
    return Span(item.file, 1, 1, 1, 2)
