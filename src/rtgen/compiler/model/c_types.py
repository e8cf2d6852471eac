"""C types and expressions in component descriptions (CDL).

tecsgen distinguishes types as *written* (`ER`): a use of a typedef is a `CTypedefType`, which
`resolve` replaces by its target. Expressions in calls (`size_is`, `count_is`, `string`) and in
`C_EXP` are not evaluated; all others are constants, evaluated to a `Literal`.
"""

from __future__ import annotations

from typing import TypeAlias

import msgspec

from rtgen.compiler.model.spelling import Unspelled
from rtgen.compiler.model.types import ScopedName
from rtgen.facts.tdr import Scalar

_PLAIN = {
    Scalar.CHAR: "char",
    Scalar.SCHAR: "signed char",
    Scalar.UCHAR: "unsigned char",
}


class CScalarType(Unspelled, frozen=True, eq=False):
    """A basic type with its qualifiers; `plain`: `char_t` was written as C's `char`."""

    spelling = frozenset({"plain"})

    kind: Scalar
    const: bool = False
    volatile: bool = False
    plain: bool = False

    def __str__(self) -> str:
        text = _PLAIN[self.kind] if self.plain else self.kind.value
        return _qualified(text, self.const, self.volatile)


class CTypedefType(msgspec.Struct, frozen=True):
    """A use of a typedef: `name` as declared (C headers: one part), `target` its type."""

    name: ScopedName
    target: CType
    const: bool = False
    volatile: bool = False

    def __str__(self) -> str:
        return _qualified("::".join(self.name), self.const, self.volatile)


class CStructType(msgspec.Struct, frozen=True):
    """A use of `struct tag`; the tag is the key of a `TecsStruct`."""

    tag: ScopedName
    const: bool = False
    volatile: bool = False

    def __str__(self) -> str:
        return _qualified("struct " + "::".join(self.tag), self.const, self.volatile)


class CEnumType(msgspec.Struct, frozen=True):
    """A use of `enum tag` (`enum8` ... by `bits`); real tecsgen cannot transfer one."""

    tag: ScopedName
    bits: int | None = None
    const: bool = False
    volatile: bool = False

    def __str__(self) -> str:
        keyword = f"enum{self.bits or ''}"
        text = f"{keyword} {'::'.join(self.tag)}"
        return _qualified(text, self.const, self.volatile)


class CPointerType(msgspec.Struct, frozen=True):
    """`target *`; the qualifiers are those after the star."""

    target: CType
    const: bool = False
    volatile: bool = False

    def __str__(self) -> str:
        return _declared(self)


class CArrayType(msgspec.Struct, frozen=True):
    """`element[size]`; `size` is None for `[]`."""

    element: CType
    size: int | None

    def __str__(self) -> str:
        return _declared(self)


class CFunctionType(msgspec.Struct, frozen=True):
    """A function; only as the target of a pointer, and never transferable."""

    returns: CType
    parameters: tuple[CType, ...]

    def __str__(self) -> str:
        return _declared(self)


class DescriptorType(msgspec.Struct, frozen=True):
    """`Descriptor(signature)`, a join made at run time."""

    signature: ScopedName

    def __str__(self) -> str:
        return f"Descriptor( {'::'.join(self.signature)} )"


CType: TypeAlias = (
    CScalarType
    | CTypedefType
    | CStructType
    | CEnumType
    | CPointerType
    | CArrayType
    | CFunctionType
    | DescriptorType
)


def resolve(type_: CType) -> CType:
    """Resolve typedefs; never returns a `CTypedefType`. Qualifiers of the typedef are dropped."""
    while isinstance(type_, CTypedefType):
        type_ = type_.target
    return type_


def _declared(type_: CType, inner: str = "") -> str:
    """Return a type in C syntax without a name: `int16_t(*)[2]` is a pointer to an array."""
    match type_:
        case CPointerType(target=target):
            qualifiers = " const" * type_.const + " volatile" * type_.volatile
            text = f"*{qualifiers}{inner}"
            if isinstance(target, CArrayType | CFunctionType):
                text = f"({text})"
            return _declared(target, text)
        case CArrayType(element=element, size=size):
            return _declared(element, f"{inner}[{'' if size is None else size}]")
        case CFunctionType(returns=returns, parameters=parameters):
            listed = ", ".join(map(str, parameters)) or "void"
            return _declared(returns, f"{inner}({listed})")
    return f"{type_}{inner}"


def _qualified(text: str, const: bool, volatile: bool) -> str:
    return "const " * const + "volatile " * volatile + text


class Literal(msgspec.Struct, frozen=True):
    """A number, truth value or text; constants are evaluated to one."""

    value: bool | int | float | str

    def __str__(self) -> str:
        if isinstance(self.value, bool):
            return "true" if self.value else "false"
        return f'"{self.value}"' if isinstance(self.value, str) else str(self.value)


class Reference(msgspec.Struct, frozen=True):
    """The value of a parameter, member or attribute of that name."""

    name: str

    def __str__(self) -> str:
        return self.name


class UnaryExpression(msgspec.Struct, frozen=True):
    """`operator` is one of `* & + - ~ !`."""

    operator: str
    operand: Expression

    def __str__(self) -> str:
        return f"{self.operator}{self.operand}"


class BinaryExpression(msgspec.Struct, frozen=True):
    """`operator` is one of C's binary operators, `[]` for a subscript, `.` for a member."""

    operator: str
    left: Expression
    right: Expression

    def __str__(self) -> str:
        if self.operator == "[]":
            return f"{self.left}[{self.right}]"
        if self.operator == ".":
            return f"{self.left}.{self.right}"
        return f"({self.left} {self.operator} {self.right})"


class ConditionalExpression(msgspec.Struct, frozen=True):
    """`condition ? yes : no`."""

    condition: Expression
    yes: Expression
    no: Expression

    def __str__(self) -> str:
        return f"({self.condition} ? {self.yes} : {self.no})"


class CastExpression(msgspec.Struct, frozen=True):
    """`(type)operand`."""

    type: CType
    operand: Expression

    def __str__(self) -> str:
        return f"({self.type}){self.operand}"


class CExpression(msgspec.Struct, frozen=True):
    """`C_EXP("text")`, only for the C compiler."""

    text: str

    def __str__(self) -> str:
        return f'C_EXP("{self.text}")'


class AggregateExpression(msgspec.Struct, frozen=True):
    """`{ a, b, {c} }`."""

    items: tuple[Expression, ...]

    def __str__(self) -> str:
        return "{ " + ", ".join(str(item) for item in self.items) + " }"


Expression: TypeAlias = (
    Literal
    | Reference
    | UnaryExpression
    | BinaryExpression
    | ConditionalExpression
    | CastExpression
    | CExpression
    | AggregateExpression
)
