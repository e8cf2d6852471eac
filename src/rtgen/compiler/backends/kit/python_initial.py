"""Python expressions of the values with which members start, by `rtgen.compiler.model.initial`."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from math import isfinite
from typing import TypeVar

from rtgen.compiler.backends.kit.quoting.python import number_literal, string_literal
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    ConstantValue,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    FixedType,
    InitialValue,
    MapType,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
)
from rtgen.compiler.model.initial import default_of, enumerator
from rtgen.compiler.typemap.python.idl import PRIMITIVES, PythonMapping
from rtgen.compiler.typemap.python.idl_names import OWN_NAMES, distinct
from rtgen.facts.primitives import FLOAT_LIMITS

_T = TypeVar("_T")


class PythonInitial:
    """The initial values of types; `own` is the default of the member, if it has one."""

    def __init__(self, mapping: PythonMapping) -> None:
        self._mapping = mapping
        self._model = mapping.model

    def expression(self, type_: Type, own: InitialValue | None = None) -> str:
        """Return an expression for the initial value."""
        default = default_of(self._model, type_, own)
        type_ = self._model.unalias(type_)
        if default is not None:
            return self.explicit(type_, default)
        mapping = self._mapping
        match type_:
            case PrimitiveType(kind):
                return mapping.spelled(PRIMITIVES[kind], PRIMITIVES[kind].default)
            case StringType():
                return '""'
            case FixedType():
                return f'{mapping.spell("decimal", "Decimal")}("0")'
            case SequenceType(numeric="numpy"):
                return self._numpy(type_, (0,))
            case SequenceType():
                empty = {None: "[]", "bytes": 'b""', "str": '""'}
                return empty[mapping.text_type(type_)]
            case ArrayType():
                return self._array(type_)
            case MapType():
                return "{}"
            case NamedType(name):
                return self._named(type_, name)

    def _named(self, type_: NamedType, name: ScopedName) -> str:
        declaration = self._model.find(name)
        match declaration:
            case Enum():
                return self.explicit(type_, enumerator(declaration))
            case Bitmask():
                return self.explicit(type_, 0)
            case Struct() | Union() | ExceptionDecl() | Bitset():
                return f"{self._mapping.name_of(name)}()"
        return "None"

    def factory(self, type_: Type, own: InitialValue | None = None) -> str:
        """Return a callable that makes the initial value of a mutable type."""
        plain = self._model.unalias(type_)
        if default_of(self._model, type_, own) is None:
            match plain:
                case SequenceType(numeric="list" | "array"):
                    return self._mapping.spell("", "list")
                case MapType():
                    return self._mapping.spell("", "dict")
                case NamedType(name):
                    return self._mapping.name_of(name)
        return f"lambda: {self.expression(type_, own)}"

    def is_inferred(self, type_: Type) -> bool:
        """Return whether the expression of the initial value alone determines the type."""
        type_ = self._model.unalias(type_)
        if not isinstance(type_, ArrayType) or self._mapping.text_type(type_):
            return True
        element = self._model.unalias(type_.element)
        if isinstance(element, SequenceType | ArrayType) and element.numeric == "array":
            return False
        unknown = self.expression(element) in ("[]", "{}", "None")
        return not unknown and self.is_inferred(element)

    def explicit(self, type_: Type, value: InitialValue) -> str:
        """Return the expression of a default for a type without aliases."""
        spell = self._mapping.spell
        match value:
            case tuple():
                assert isinstance(type_, SequenceType | ArrayType)
                return self._items(type_, value)
            case EnumeratorName(name):
                assert isinstance(type_, NamedType)
                enum = self._model.find(type_.name)
                assert isinstance(enum, Enum)
                names = distinct((m.name for m in enum.members), OWN_NAMES[Enum])
                return f"{self._mapping.name_of(type_.name)}.{names[name[-1]]}"
            case str():
                return string_literal(value)
            case Decimal():
                return f'{spell("decimal", "Decimal")}("{value}")'
            case float() if not isfinite(value):
                return f'{spell("", "float")}("{value}")'
        if isinstance(type_, NamedType):
            return self._flags(type_, int(value))
        if isinstance(type_, PrimitiveType) and type_.kind in FLOAT_LIMITS:
            value = float(value)
        return number_literal(value)

    def _flags(self, type_: NamedType, number: int) -> str:
        """Return the expression of a bitmask: its flags by their names, if all have one."""
        class_ = self._mapping.name_of(type_.name)
        mask = self._model.find(type_.name)
        assert isinstance(mask, Bitmask)
        names = distinct((m.name for m in mask.members), OWN_NAMES[Enum])
        flags = [m for m in mask.members if number >> m.value & 1]
        if not flags or sum(1 << m.value for m in flags) != number:
            return f"{class_}({number})"
        return " | ".join(f"{class_}.{names[m.name]}" for m in flags)

    def _items(
        self, type_: SequenceType | ArrayType, values: Sequence[ConstantValue]
    ) -> str:
        """Return the expression of a list with these items, those of arrays in a row."""
        element = self._model.unalias(type_.element)
        items = [self.explicit(element, value) for value in values]
        dimensions: tuple[int, ...] = (len(items),)
        if isinstance(type_, ArrayType):
            dimensions = type_.dimensions
        if self._mapping.text_type(type_) == "str":
            rows = _rows([*values], dimensions[-1])
            items = [string_literal("".join(map(str, row))) for row in rows]
        else:
            items = [f"[{', '.join(row)}]" for row in _rows(items, dimensions[-1])]
        if self._mapping.text_type(type_) == "bytes":
            octets = self._mapping.spell("", "bytes")
            items = [f"{octets}({item})" for item in items]
        for size in reversed(dimensions[:-1]):
            items = [f"[{', '.join(row)}]" for row in _rows(items, size)]
        [expression] = items
        if type_.numeric == "numpy":
            numpy = self._mapping.spell("numpy", "numpy")
            return f"{numpy}.array({expression}, {self._mapping.item(type_)})"
        return expression

    def _array(self, type_: ArrayType) -> str:
        """Return the expression of an array of equal items."""
        if type_.numeric == "numpy":
            return self._numpy(type_, type_.dimensions)
        mapping = self._mapping
        *outer, last = type_.dimensions
        item = self.expression(type_.element)
        match mapping.text_type(type_):
            case "bytes" if item == "0":
                expression = f"{mapping.spell('', 'bytes')}({last})"
            case "bytes":
                expression = f"{mapping.spell('', 'bytes')}([{item}] * {last})"
            case "str":
                expression = f"{item} * {last}"
            case _ if mapping.immutable(type_.element):
                expression = f"[{item}] * {last}"
            case _:
                expression = f"[{item} for _ in range({last})]"
        for size in reversed(outer):
            expression = f"[{expression} for _ in range({size})]"
        return expression

    def _numpy(self, type_: SequenceType | ArrayType, shape: tuple[int, ...]) -> str:
        """Return the expression of a numpy array of equal items."""
        mapping = self._mapping
        sizes = ", ".join(map(str, shape))
        idl = mapping.spell("rtgen.runtime", "idl")
        if mapping.number_kind(type_) is None:
            element = self._model.unalias(type_.element)
            kind = "zeros" if 0 in shape or self._is_zero(element) else "records"
            return f"{idl}.{kind}({mapping.annotation(element)}, {sizes})"
        if 0 in shape or self._is_zero(type_.element):
            return f"{idl}.zeros({mapping.item(type_)}, {sizes})"
        numpy = mapping.spell("numpy", "numpy")
        size = f"({sizes})" if len(shape) > 1 else sizes
        item = self.expression(type_.element)
        return f"{numpy}.full({size}, {item}, {mapping.item(type_)})"

    def _is_zero(self, type_: Type, own: InitialValue | None = None) -> bool:
        """Return whether a number, or each number in an array or a struct, starts as zero."""
        default = default_of(self._model, type_, own)
        if default is not None:
            return not any(default if isinstance(default, tuple) else (default,))
        match self._model.unalias(type_):
            case ArrayType(element):
                return self._is_zero(element)
            case NamedType(name):
                struct = self._model.find(name)
                assert isinstance(struct, Struct)
                return all(self._is_zero(m.type, m.initial) for m in struct.members)
        return True


def _rows(items: list[_T], size: int) -> list[list[_T]]:
    """Split items into rows; without any there is one empty row."""
    return [items[at : at + size] for at in range(0, len(items), size or 1)] or [[]]
