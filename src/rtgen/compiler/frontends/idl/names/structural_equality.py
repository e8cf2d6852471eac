"""Structural equality of declarations, ignoring their places in the text."""

from __future__ import annotations

from msgspec import Struct

_PLACE = frozenset(("start", "end", "span", "file", "doc"))


def structurally_equal(one: object, other: object) -> bool:
    """Return whether two nodes or declarations are equal except for their places."""
    if type(one) is not type(other):
        return False
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(structurally_equal, one, other))
    if isinstance(one, Struct):
        return all(
            structurally_equal(getattr(one, name), getattr(other, name))
            for name in one.__struct_fields__
            if name not in _PLACE
        )
    return one == other
