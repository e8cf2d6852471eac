"""Type expressions, as every front end gives them and every back end takes them.

A named type is a reference by scoped name; `Model.find` gives its declaration. So the model is a
plain value without cycles, also where types are recursive.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

ScopedName: TypeAlias = tuple[str, ...]
"""A name from the global scope down: `("IIS", "TimedPose2D")`; escape underscores removed."""


class Primitive(StrEnum):
    """The basic types; the value is the canonical spelling (OMG IDL 4.2, 7.4.1.4.4.2)."""

    SHORT = "short"
    UNSIGNED_SHORT = "unsigned short"
    LONG = "long"
    UNSIGNED_LONG = "unsigned long"
    LONG_LONG = "long long"
    UNSIGNED_LONG_LONG = "unsigned long long"
    INT8 = "int8"
    UINT8 = "uint8"
    FLOAT = "float"
    DOUBLE = "double"
    LONG_DOUBLE = "long double"
    CHAR = "char"
    WCHAR = "wchar"
    BOOLEAN = "boolean"
    OCTET = "octet"
    ANY = "any"
    OBJECT = "Object"
    VALUE_BASE = "ValueBase"
    TYPE_CODE = "CORBA::TypeCode"
    VOID = "void"


INTEGER_RANGES = {
    Primitive.SHORT: (-(2**15), 2**15 - 1),
    Primitive.UNSIGNED_SHORT: (0, 2**16 - 1),
    Primitive.LONG: (-(2**31), 2**31 - 1),
    Primitive.UNSIGNED_LONG: (0, 2**32 - 1),
    Primitive.LONG_LONG: (-(2**63), 2**63 - 1),
    Primitive.UNSIGNED_LONG_LONG: (0, 2**64 - 1),
    Primitive.INT8: (-(2**7), 2**7 - 1),
    Primitive.UINT8: (0, 2**8 - 1),
    Primitive.OCTET: (0, 2**8 - 1),
}
"""The least and the greatest value of each integer type (OMG IDL 4.2, 7.4.1.4.4.2 and 7.4.13)."""


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
