"""Equality of values that have numpy arrays as members, whose `==` compares item by item."""

from __future__ import annotations

from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    ExceptionDescriptor,
    Named,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
)


def holds_numpy(descriptor: Named | None) -> bool:
    """Whether a member of a struct or exception, or a branch of a union, is a numpy array."""
    match descriptor:
        case StructDescriptor(members=entries) | ExceptionDescriptor(members=entries):
            types = [member.type for member in entries]
        case UnionDescriptor(branches=branches):
            types = [branch.type for branch in branches]
        case _:
            return False
    return any(map(_is_numpy, types))


def _is_numpy(type_: Any) -> bool:
    while isinstance(type_, AliasDescriptor):
        type_ = type_.target
    if not isinstance(type_, SequenceDescriptor | ArrayDescriptor):
        return False
    return type_.numeric == "numpy" or _is_numpy(type_.element)


def same(one: Any, other: Any) -> bool:
    """Whether both are equal, with numpy arrays inside of lists, too."""
    if hasattr(one, "dtype") or hasattr(other, "dtype"):
        import numpy

        return bool(numpy.array_equal(one, other))
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def same_members(self: Any, other: Any) -> Any:
    """`__eq__` of a struct or union: of one class, with equal members."""
    if type(other) is not type(self):
        return NotImplemented
    return all(
        same(getattr(self, name), getattr(other, name))
        for name in self.__struct_fields__
    )
