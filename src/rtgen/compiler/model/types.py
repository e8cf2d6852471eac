"""Type expressions, common to all front ends and back ends.

A named type is a reference by scoped name; `Model.find` returns its declaration. So the model is
a plain value without cycles, even if types are recursive.
"""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from rtgen.facts.numeric import Numeric
from rtgen.facts.primitives import Primitive

ScopedName: TypeAlias = tuple[str, ...]
"""A name from the global scope down: `("IIS", "TimedPose2D")`; escape underscores removed."""


def default_id(name: ScopedName) -> str:
    """Return the repository id of a declaration that does not state one."""
    return f"IDL:{'/'.join(name)}:1.0"


class PrimitiveType(msgspec.Struct, frozen=True):
    """A basic type."""

    kind: Primitive

    def __str__(self) -> str:
        return self.kind.value


class StringType(msgspec.Struct, frozen=True):
    """`string`, `wstring`, either with a bound in characters."""

    wide: bool = False
    bound: int | None = None

    def __str__(self) -> str:
        name = "wstring" if self.wide else "string"
        return name if self.bound is None else f"{name}<{self.bound}>"


class SequenceType(msgspec.Struct, frozen=True):
    """`sequence<T>` or `sequence<T,bound>`; `numeric` is its form in Python."""

    element: Type
    bound: int | None = None
    numeric: Numeric = "list"

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"sequence<{self.element}{bound}>"


class ArrayType(msgspec.Struct, frozen=True):
    """`T name[a][b]`; dimensions outermost first. The element is never an array itself."""

    element: Type
    dimensions: tuple[int, ...]
    numeric: Numeric = "list"

    def __str__(self) -> str:
        return str(self.element) + "".join(f"[{n}]" for n in self.dimensions)


class FixedType(msgspec.Struct, frozen=True):
    """`fixed<digits,scale>`."""

    digits: int
    scale: int

    def __str__(self) -> str:
        return f"fixed<{self.digits},{self.scale}>"


class MapType(msgspec.Struct, frozen=True):
    """`map<K,V>` or `map<K,V,bound>` (IDL 4.2)."""

    key: Type
    value: Type
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"map<{self.key},{self.value}{bound}>"


class NamedType(msgspec.Struct, frozen=True):
    """A reference to a declared type."""

    name: ScopedName

    def __str__(self) -> str:
        return "::".join(self.name)


Type: TypeAlias = (
    PrimitiveType
    | StringType
    | SequenceType
    | ArrayType
    | FixedType
    | MapType
    | NamedType
)

VOID = PrimitiveType(Primitive.VOID)
