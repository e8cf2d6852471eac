"""Structural equality of declarations, ignoring their places in the text."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

_PLACE = frozenset(("start", "end", "span", "file", "doc"))


def structurally_equal(one: object, other: object) -> bool:
    """Whether two nodes of the tree, or two declarations, are equal except for their places."""
    if type(one) is not type(other):
        return False
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(structurally_equal, one, other))
    if is_dataclass(one):
        return all(
            structurally_equal(getattr(one, field.name), getattr(other, field.name))
            for field in fields(one)
            if field.name not in _PLACE
        )
    return one == other
