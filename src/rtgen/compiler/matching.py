"""Matches the named items of two versions: by name, then renamed ones by shape."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

Name = TypeVar("Name", bound=Hashable)
Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Matching(Generic[Name, Item]):
    """Items in both versions, under one name or `renamed`, and items in only one of them."""

    pairs: tuple[tuple[Item, Item], ...]
    renamed: tuple[tuple[Item, Item], ...]
    removed: tuple[Item, ...]
    added: tuple[Item, ...]


def matching(
    old: Mapping[Name, Item],
    new: Mapping[Name, Item],
    shape: Callable[[Item], Hashable | None] = lambda _: None,
    new_shape: Callable[[Item], Hashable | None] | None = None,
) -> Matching[Name, Item]:
    """Match two versions. A renamed item is the only one of its shape on both sides.

    `shape` returns everything except the name, `new_shape` that of the new items, if it is another
    function; None, the default, for items that are matched by name only.
    """
    gone = {name: item for name, item in old.items() if name not in new}
    come = {name: item for name, item in new.items() if name not in old}
    by_shape = _by_shape(come, new_shape or shape)
    renamed = {}
    for found, names in _by_shape(gone, shape).items():
        others = by_shape.get(found, [])
        if len(names) == len(others) == 1:
            renamed[names[0]] = others[0]
    taken = set(renamed.values())
    return Matching(
        tuple((item, new[name]) for name, item in old.items() if name in new),
        tuple((gone[name], come[other]) for name, other in renamed.items()),
        tuple(item for name, item in gone.items() if name not in renamed),
        tuple(item for name, item in come.items() if name not in taken),
    )


def _by_shape(
    items: Mapping[Name, Item], shape: Callable[[Item], Hashable | None]
) -> dict[Hashable, list[Name]]:
    found: dict[Hashable, list[Name]] = defaultdict(list)
    for name, item in items.items():
        key = shape(item)
        if key is not None:
            found[key].append(name)
    return found
