"""Equality of values that have numpy arrays as members, whose `==` compares item by item."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BranchDescriptor,
    ExceptionDescriptor,
    MemberDescriptor,
    Named,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
)

_COLLECTIONS: Final = (AliasDescriptor, ArrayDescriptor, SequenceDescriptor)


def holds_numpy(descriptor: Named | None) -> bool:
    """Return whether a member of a struct or exception, or a union's branch, is a numpy array."""
    entries: Iterable[MemberDescriptor | BranchDescriptor] = ()
    if isinstance(descriptor, StructDescriptor | ExceptionDescriptor):
        entries = descriptor.members
    elif isinstance(descriptor, UnionDescriptor):
        entries = descriptor.branches
    # This examines each member when its module is imported: most have a primitive type.
    return any(type(e.type) in _COLLECTIONS and _is_numpy(e.type) for e in entries)


def _is_numpy(type_: Any) -> bool:
    while isinstance(type_, AliasDescriptor):
        type_ = type_.target
    if not isinstance(type_, SequenceDescriptor | ArrayDescriptor):
        return False
    return type_.numeric == "numpy" or _is_numpy(type_.element)


def same(one: Any, other: Any) -> bool:
    """Return whether two values are equal, also with numpy arrays inside lists."""
    if hasattr(one, "dtype") or hasattr(other, "dtype"):
        import numpy

        return bool(numpy.array_equal(one, other))
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def same_members(self: Any, other: Any) -> Any:
    """Implement `__eq__` of a struct or union: same class, equal members."""
    if type(other) is not type(self):
        return NotImplemented
    return all(
        same(getattr(self, name), getattr(other, name))
        for name in self.__struct_fields__
    )
