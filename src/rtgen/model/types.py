"""Type expressions, common to all front ends and back ends.

A named type is a reference by scoped name; `Model.find` returns its declaration. So the model is
a plain value without cycles, even if types are recursive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from rtgen.facts.primitives import Primitive

ScopedName: TypeAlias = tuple[str, ...]
"""A name from the global scope down: `("IIS", "TimedPose2D")`; escape underscores removed."""


@dataclass(frozen=True, slots=True)
class PrimitiveType:
    """A basic type."""

    kind: Primitive

    def __str__(self) -> str:
        return self.kind.value


@dataclass(frozen=True, slots=True)
class StringType:
    """`string`, `wstring`, either with a bound in characters."""

    wide: bool = False
    bound: int | None = None

    def __str__(self) -> str:
        name = "wstring" if self.wide else "string"
        return name if self.bound is None else f"{name}<{self.bound}>"


@dataclass(frozen=True, slots=True)
class SequenceType:
    """`sequence<T>` or `sequence<T,bound>`."""

    element: Type
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"sequence<{self.element}{bound}>"


@dataclass(frozen=True, slots=True)
class ArrayType:
    """`T name[a][b]`; dimensions outermost first. The element is never an array itself."""

    element: Type
    dimensions: tuple[int, ...]

    def __str__(self) -> str:
        return str(self.element) + "".join(f"[{n}]" for n in self.dimensions)


@dataclass(frozen=True, slots=True)
class FixedType:
    """`fixed<digits,scale>`."""

    digits: int
    scale: int

    def __str__(self) -> str:
        return f"fixed<{self.digits},{self.scale}>"


@dataclass(frozen=True, slots=True)
class MapType:
    """`map<K,V>` or `map<K,V,bound>` (IDL 4.2)."""

    key: Type
    value: Type
    bound: int | None = None

    def __str__(self) -> str:
        bound = "" if self.bound is None else f",{self.bound}"
        return f"map<{self.key},{self.value}{bound}>"


@dataclass(frozen=True, slots=True)
class NamedType:
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
