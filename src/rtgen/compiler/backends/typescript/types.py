"""IDL types in TypeScript: the type of values, and the expression of the codec."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, TypeVar

from rtgen.compiler.backends.kit.quoting import typescript as quoting
from rtgen.compiler.layouts.representations import Representations, member_types
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    ConstantValue,
    Declaration,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Extensibility,
    InitialValue,
    MapType,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
)
from rtgen.compiler.model.initial import default_of
from rtgen.facts.primitives import OCTET_TYPES

_BASIC: Final = {
    Primitive.BOOLEAN: ("boolean", "boolean"),
    Primitive.CHAR: ("char", "string"),
    Primitive.WCHAR: ("wchar", "string"),
    Primitive.OCTET: ("octet", "number"),
    Primitive.UINT8: ("octet", "number"),
    Primitive.INT8: ("int8", "number"),
    Primitive.SHORT: ("short", "number"),
    Primitive.UNSIGNED_SHORT: ("ushort", "number"),
    Primitive.LONG: ("long", "number"),
    Primitive.UNSIGNED_LONG: ("ulong", "number"),
    Primitive.LONG_LONG: ("longlong", "bigint"),
    Primitive.UNSIGNED_LONG_LONG: ("ulonglong", "bigint"),
    Primitive.FLOAT: ("float", "number"),
    Primitive.DOUBLE: ("double", "number"),
}
"""Codec and type of the basic types."""

_T = TypeVar("_T")

BIG: Final = frozenset((Primitive.LONG_LONG, Primitive.UNSIGNED_LONG_LONG))
"""The types whose values are a `bigint`."""


def identifier(name: ScopedName) -> str:
    """Return the name of a declaration in its module; the `$` prevents clashes with keywords."""
    return "$".join(name) if len(name) > 1 else f"{name[0]}$"


class Types:
    """The types of a model."""

    def __init__(self, model: Model, representations: Representations) -> None:
        self._model = model
        self._representations = representations
        self._missing: dict[ScopedName, str] = {}
        settled = False
        while not settled:  # Repeated only for types that contain each other.
            settled = True
            for declaration in model.declarations:
                if declaration.name not in self._missing:
                    what = self._missing_in(declaration)
                    if what is not None:
                        self._missing[declaration.name] = what
                        settled = False

    def missing(self, declaration: Declaration) -> str | None:
        """Return the part of a declaration that has no codec; None if it has one."""
        return self._missing.get(declaration.name)

    def _missing_in(self, declaration: Declaration) -> str | None:
        match declaration:
            case Struct() | Union():
                how = self._representations.extensibility(declaration)
                if how is Extensibility.MUTABLE:
                    return f"the mutable type {declaration.scoped}"
                parts = member_types(declaration)
                if isinstance(declaration, Union):
                    parts.append(declaration.switch)
            case ExceptionDecl(members=members):
                parts = [member.type for member in members]
            case Typedef(type=type_):
                parts = [type_]
            case Enum(bound=bound) if bound > 32:
                return f"an enum of {bound} bits"
            case Enum() | Bitmask():
                return None
            case _:
                return declaration.scoped
        reasons = (self._missing_of(part) for part in parts)
        return next((what for what in reasons if what is not None), None)

    def _missing_of(self, type_: Type) -> str | None:
        match type_:
            case PrimitiveType(kind):
                return None if kind in _BASIC else str(kind)
            case StringType():
                return None
            case SequenceType(element) | ArrayType(element):
                return self._missing_of(element)
            case MapType(key, value):
                plain = self._model.unalias(key)
                if not isinstance(plain, PrimitiveType | StringType):
                    return f"a map by {key}"
                return self._missing_of(key) or self._missing_of(value)
            case NamedType(name):
                return self._missing.get(name)
        return str(type_)

    def is_appendable(self, declaration: Struct | Union) -> bool:
        """Return whether a DHEADER precedes its values in version 2."""
        how = self._representations.extensibility(declaration)
        return how is Extensibility.APPENDABLE

    def value(self, type_: Type) -> str:
        """Return the type of values in TypeScript."""
        match type_:
            case PrimitiveType(kind):
                return _BASIC[kind][1]
            case StringType():
                return "string"
            case SequenceType(element):
                special = self._special(element)
                return special[1] if special else f"{_grouped(self.value(element))}[]"
            case ArrayType():
                element, dimensions = self._flat(type_)
                special = self._special(element)
                text = special[1] if special else _grouped(self.value(element))
                return text + "[]" * (len(dimensions) - (special is not None))
            case MapType(key, value):
                return f"Map<{self.value(key)}, {self.value(value)}>"
            case NamedType(name):
                return identifier(name)
        raise AssertionError(f"{type_} was reported")

    def codec(self, type_: Type, refer: Callable[[ScopedName], bool]) -> str:
        """Return the expression of the codec.

        `refer` is called with each name that it uses, and returns whether the name is already
        defined.
        """
        match type_:
            case PrimitiveType(kind):
                return _BASIC[kind][0]
            case StringType(wide, bound):
                return f"{'wstring' if wide else 'string'}({bound or ''})"
            case SequenceType(element, bound):
                special = self._special(element)
                if special:
                    return f"{special[0]}({bound or ''})"
                inner = self.codec(element, refer)
                return f"sequence({inner}{f', {bound}' if bound else ''})"
            case ArrayType():
                return self._array(type_, refer)
            case MapType(key, value, bound):
                inner = f"{self.codec(key, refer)}, {self.codec(value, refer)}"
                return f"map({inner}{f', {bound}' if bound else ''})"
            case NamedType(name):
                text = identifier(name)
                if refer(name):
                    return text
                return f"lazy({quoting.string('::'.join(name))}, () => {text})"
        raise AssertionError(f"{type_} was reported")

    def literal(self, plain: Type, value: ConstantValue) -> str:
        """Return the literal of a value of a type without aliases."""
        if isinstance(value, EnumeratorName):
            return quoting.string(value.name[-1])
        big = isinstance(plain, PrimitiveType) and plain.kind in BIG
        if isinstance(plain, NamedType):
            declared = self._model.find(plain.name)
            big = isinstance(declared, Bitmask) and declared.bound > 32
        return quoting.constant(value, is_64_bit=big)

    def initial(self, type_: Type, own: InitialValue | None) -> str | None:
        """Return the expression of a default, if a codec does not start with it by itself.

        `own` is the default of the member. The codec of an array of arrays does not know a default
        of the inner ones, since it has all dimensions.
        """
        if own is not None:
            return self._default(type_, own)
        if not isinstance(type_, ArrayType):
            return None
        inner = self._model.unalias(type_.element)
        if not isinstance(inner, ArrayType):
            return None
        text = self.initial(inner, default_of(self._model, type_.element))
        for length in reversed(type_.dimensions) if text is not None else ():
            text = f"Array.from({{ length: {length} }}, () => {text})"
        return text

    def _default(self, type_: Type, value: InitialValue) -> str:
        """Return the expression of a default: a literal, or a list with its items."""
        plain = self._model.unalias(type_)
        if not isinstance(value, tuple):
            return self.literal(plain, value)
        assert isinstance(plain, SequenceType | ArrayType)
        dimensions: tuple[int, ...] = (len(value),)
        element = self._model.unalias(plain.element)
        if isinstance(plain, ArrayType):
            dimensions = plain.dimensions
        rows = _rows(value, dimensions[-1])
        special = self._special(element)
        if special is not None and special[1] == "string":
            items: list[str] = [quoting.string("".join(map(str, row))) for row in rows]
        else:
            head, end = ("Uint8Array.of(", ")") if special is not None else ("[", "]")
            texts = ([self.literal(element, item) for item in row] for row in rows)
            items = [f"{head}{', '.join(row)}{end}" for row in texts]
        for size in reversed(dimensions[:-1]):
            items = [f"[{', '.join(row)}]" for row in _rows(items, size)]
        [expression] = items
        return expression

    def _array(self, type_: ArrayType, refer: Callable[[ScopedName], bool]) -> str:
        element, dimensions = self._flat(type_)
        inner = self.codec(element, refer)
        sizes = ", ".join(map(str, dimensions))
        return f"array<{self.value(type_)}>({inner}, {sizes})"

    def _flat(self, type_: ArrayType) -> tuple[Type, tuple[int, ...]]:
        """Return element and dimensions, resolving typedefs of arrays."""
        element, dimensions = type_.element, type_.dimensions
        while isinstance(plain := self._model.unalias(element), ArrayType):
            element, dimensions = plain.element, dimensions + plain.dimensions
        return element, dimensions

    def _special(self, element: Type) -> tuple[str, str] | None:
        """Return codec and type of a sequence of octets or characters."""
        plain = self._model.unalias(element)
        if isinstance(plain, PrimitiveType):
            if plain.kind in OCTET_TYPES:
                return "octets", "Uint8Array"
            if plain.kind is Primitive.CHAR:
                return "chars", "string"
        return None


def _grouped(text: str) -> str:
    return f"({text})" if "|" in text else text


def _rows(items: Sequence[_T], size: int) -> list[Sequence[_T]]:
    """Split items into rows; without any there is one empty row."""
    return [items[at : at + size] for at in range(0, len(items), size or 1)] or [()]
