"""Predicates of C types: depth, constness, pointers, types known by name only."""

from __future__ import annotations

from rtgen.compiler.model.c_types import (
    CArrayType,
    CFunctionType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    CTypedefType,
    resolve,
)
from rtgen.facts.tdr import Scalar

MAX_DEPTH = 64
"""The largest nesting depth of pointers, arrays, functions and typedefs."""


def depth(type_: CType) -> int:
    """Return the nesting depth of a type."""
    depth_so_far = 1
    while True:
        if isinstance(type_, CPointerType | CTypedefType):
            type_ = type_.target
        elif isinstance(type_, CArrayType):
            type_ = type_.element
        elif isinstance(type_, CFunctionType):
            return depth_so_far + max(map(depth, (type_.returns, *type_.parameters)))
        else:
            return depth_so_far
        depth_so_far += 1


OPAQUE = "unknown "


def opaque(name: str) -> CStructType:
    """Return a placeholder for a type known by name only, or without counterpart in CDL."""
    return CStructType((f"{OPAQUE}{name}",))


def pointer_depth(type_: CType) -> int:
    """Return the number of pointer levels; arrays do not count."""
    depth = 0
    resolved = resolve(type_)
    while isinstance(resolved, CPointerType):
        resolved = resolve(resolved.target)
        depth += 1
    return depth


def is_const(type_: CType) -> bool:
    """Return whether the value itself may not change; of an array, its elements."""
    while True:
        if isinstance(type_, CArrayType):
            type_ = type_.element
        elif isinstance(type_, CTypedefType) and not type_.const:
            type_ = type_.target
        else:
            return getattr(type_, "const", False)


def is_void(type_: CType) -> bool:
    """Return whether a type is `void`, directly or by a typedef."""
    resolved = resolve(type_)
    return isinstance(resolved, CScalarType) and resolved.kind is Scalar.VOID
