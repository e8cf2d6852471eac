"""Whether two declarations say the same, wherever they stand."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

_PLACE = frozenset(("start", "end", "span", "file", "doc"))


def alike(one: object, other: object) -> bool:
    """Whether two nodes of the tree, or two declarations, differ in their place at most."""
    if type(one) is not type(other):
        return False
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if is_dataclass(one):
        return all(
            alike(getattr(one, field.name), getattr(other, field.name))
            for field in fields(one)
            if field.name not in _PLACE
        )
    return one == other
