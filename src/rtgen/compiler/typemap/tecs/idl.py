"""TECS to IDL: Table 1 of the RTM-TECS publication and its extension.

IDL expresses less than CDL: it has no sign of an `int8_t`, and no length of a buffer. The mapping
keeps the bits; `docs/tecs.md` describes the differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from rtgen.compiler.model import (
    VOID,
    ArrayType,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Type,
)
from rtgen.compiler.model.c_types import (
    CArrayType,
    CEnumType,
    CFunctionType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    CTypedefType,
    DescriptorType,
    Expression,
    Literal,
    resolve,
)
from rtgen.compiler.model.tecs import (
    Sizes,
    TecsDirection,
    TecsParameter,
    TecsUnit,
)
from rtgen.facts.tdr import Scalar

TABLE_1 = {
    Scalar.CHAR: Primitive.CHAR,
    Scalar.UCHAR: Primitive.CHAR,
    Scalar.INT8: Primitive.OCTET,
    Scalar.UINT8: Primitive.OCTET,
    Scalar.INT16: Primitive.SHORT,
    Scalar.UINT16: Primitive.UNSIGNED_SHORT,
    Scalar.INT32: Primitive.LONG,
    Scalar.UINT32: Primitive.UNSIGNED_LONG,
    Scalar.INT64: Primitive.LONG_LONG,
    Scalar.UINT64: Primitive.UNSIGNED_LONG_LONG,
    Scalar.FLOAT32: Primitive.FLOAT,
    Scalar.DOUBLE64: Primitive.DOUBLE,
    Scalar.BOOL: Primitive.BOOLEAN,
}
"""The scalars of Yawata, Azumi, Nishio: Table 1; its rows for strings and arrays are `_sized`."""

EXTENSION = {
    Scalar.SCHAR: Primitive.OCTET,
    Scalar.LONG_LONG: Primitive.LONG_LONG,
    Scalar.ULONG_LONG: Primitive.UNSIGNED_LONG_LONG,
}
"""Scalars of fixed width that are not in Table 1."""

BY_WIDTH = {
    (16, True): Primitive.SHORT,
    (16, False): Primitive.UNSIGNED_SHORT,
    (32, True): Primitive.LONG,
    (32, False): Primitive.UNSIGNED_LONG,
    (64, True): Primitive.LONG_LONG,
    (64, False): Primitive.UNSIGNED_LONG_LONG,
}
"""Integer types by width and sign."""

_EIGHT_BITS = frozenset(
    (Scalar.CHAR, Scalar.SCHAR, Scalar.UCHAR, Scalar.INT8, Scalar.UINT8)
)


@dataclass(frozen=True, slots=True)
class Widths:
    """Widths of C's types without a fixed width, at the peer."""

    short: int = 16
    int_: int = 32
    long: int = 32
    intptr: int = 32

    def of(self, kind: Scalar) -> tuple[int, bool] | None:
        """Return the width and whether the type is signed; None for other types."""
        return {
            Scalar.SHORT: (self.short, True),
            Scalar.USHORT: (self.short, False),
            Scalar.INT: (self.int_, True),
            Scalar.UINT: (self.int_, False),
            Scalar.LONG: (self.long, True),
            Scalar.ULONG: (self.long, False),
            Scalar.INTPTR: (self.intptr, True),
            Scalar.UINTPTR: (self.intptr, False),
        }.get(kind)


class NotInIdlError(Exception):
    """A type without an IDL equivalent; `hint` suggests an alternative."""

    def __init__(self, reason: str, hint: str = "") -> None:
        super().__init__(reason)
        self.hint = hint


class IdlTypes:
    """The IDL types of CDL types in one unit.

    `structs` and `typedefs` map to names in IDL; types missing there are resolved.
    """

    def __init__(
        self,
        unit: TecsUnit,
        widths: Widths,
        structs: Mapping[ScopedName, ScopedName],
        typedefs: Mapping[ScopedName, ScopedName],
    ) -> None:
        self._declared = unit.structs
        self._structs = structs
        self._typedefs = typedefs
        self._widths = widths
        self._sound: set[ScopedName] = set()

    def returns(self, type_: CType) -> Type:
        """Return the type of a return value. Raises NotInIdlError, as the other methods do."""
        if resolve(type_) == CScalarType(Scalar.VOID):
            return VOID
        return self.type(type_)

    def parameter(self, parameter: TecsParameter) -> Type:
        """Return the type of a parameter; the pointer of an outward one is dropped."""
        type_ = parameter.type
        if parameter.direction is TecsDirection.RECEIVE:
            type_ = _target(type_)
        if parameter.sizes == Sizes() and isinstance(resolve(type_), CPointerType):
            type_ = _target(type_)
        return self.sized(type_, parameter.sizes)

    def sized(self, type_: CType, sizes: Sizes) -> Type:
        """Return the type of a parameter or struct member with its specifiers."""
        if sizes.nullable:
            bare = replace(sizes, nullable=False)
            present = _target(type_) if bare == Sizes() else type_
            return SequenceType(self.sized(present, bare), 1)
        if sizes.size_is is not None or sizes.count_is is not None:
            element = _target(type_)
            inner = Sizes(string=sizes.string, unsized_string=sizes.unsized_string)
            return SequenceType(self.sized(element, inner), _bound(sizes))
        if sizes.is_string:
            return self._string(type_)
        return self.type(type_)

    def type(self, type_: CType) -> Type:
        """Return the type of a value without specifiers. Raises NotInIdlError."""
        match type_:
            case CTypedefType(name, target):
                plain = self.type(target)
                return (
                    NamedType(self._typedefs[name]) if name in self._typedefs else plain
                )
            case CScalarType(kind):
                return self._scalar(kind)
            case CStructType(tag):
                return self._struct(tag)
            case CPointerType(target):
                return self.type(target)
            case CArrayType():
                return self._array(type_)
            case CEnumType():
                raise NotInIdlError(
                    f"`{type_}` cannot be transferred by real tecsgen",
                    "use an integer type of fixed width",
                )
            case CFunctionType():
                raise NotInIdlError("a function pointer cannot be transferred")
            case DescriptorType():
                raise NotInIdlError(f"`{type_}` makes sense within one program only")

    def _scalar(self, kind: Scalar) -> PrimitiveType:
        if kind is Scalar.VOID:
            raise NotInIdlError("no value travels for a `void *`")
        width = self._widths.of(kind)
        if width is not None:
            return PrimitiveType(BY_WIDTH[width])
        primitive = TABLE_1.get(kind) or EXTENSION.get(kind)
        if primitive is None:
            raise NotInIdlError(
                f"IDL has no integer of the width of `{kind}`",
                "the generated codec can carry it, but no service port can",
            )
        return PrimitiveType(primitive)

    def _struct(self, tag: ScopedName, inside: tuple[ScopedName, ...] = ()) -> Type:
        shown = f"`struct {'::'.join(tag)}`"
        if tag not in self._declared:
            raise NotInIdlError(f"{shown} is declared, not defined")
        if tag in inside:
            raise NotInIdlError(f"{shown} holds itself, without end")
        if tag not in self._sound:
            for member in self._declared[tag].members:
                held = _inner_struct(member.type)
                if held is not None:
                    self._struct(held, (*inside, tag))
                try:
                    self.sized(member.type, member.sizes)
                except NotInIdlError as reason:
                    raise NotInIdlError(
                        f"`{member.name}` of {shown}: {reason}", reason.hint
                    ) from None
            self._sound.add(tag)
        return NamedType(self._structs[tag])

    def _array(self, type_: CArrayType) -> ArrayType:
        dimensions = []
        element: CType = type_
        while isinstance(element, CArrayType):
            if element.size is None:
                raise NotInIdlError("an array without a size", "add size_is(...)")
            dimensions.append(element.size)
            element = resolve(element.element)
        return ArrayType(self.type(_innermost(type_)), tuple(dimensions))

    def _string(self, type_: CType) -> Type:
        unit = resolve(_target(type_))
        if not isinstance(unit, CScalarType):
            raise NotInIdlError(f"a string of `{unit}`")
        if unit.kind in _EIGHT_BITS:
            return StringType()
        return SequenceType(self._scalar(unit.kind))


def _target(type_: CType) -> CType:
    """Return the target of a pointer, or the element of an array."""
    plain = resolve(type_)
    if isinstance(plain, CPointerType):
        return plain.target
    return plain.element if isinstance(plain, CArrayType) else type_


def _innermost(type_: CType) -> CType:
    """Return the element of an array of arrays, through typedefs of arrays."""
    while isinstance(plain := resolve(type_), CArrayType):
        type_ = plain.element
    return type_


def _inner_struct(type_: CType) -> ScopedName | None:
    """Return the struct that a member contains or points to."""
    plain = resolve(type_)
    while isinstance(plain, CPointerType | CArrayType):
        inner = plain.target if isinstance(plain, CPointerType) else plain.element
        plain = resolve(inner)
    return plain.tag if isinstance(plain, CStructType) else None


def _bound(sizes: Sizes) -> int | None:
    """Return the maximum number of elements, if it is constant."""
    if sizes.max_size is not None:
        return sizes.max_size
    return _constant(sizes.size_is)


def _constant(expression: Expression | None) -> int | None:
    if isinstance(expression, Literal) and isinstance(expression.value, int):
        return int(expression.value)
    return None
