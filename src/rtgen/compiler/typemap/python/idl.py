"""IDL to Python: annotations and initial values of types (OMG IDL to Python mapping 1.3).

The table follows the mapping where it has a Python type (sequences of octets are `bytes`, of
characters `str`, enums and structs classes), with dataclasses, `IntEnum` and type hints in place
of its dynamic types.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import msgspec

from rtgen.compiler.model import (
    VOID,
    ArrayType,
    Bitfield,
    ExceptionDecl,
    FixedType,
    Home,
    Interface,
    MapType,
    Model,
    NamedType,
    Native,
    Operation,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.components import Component
from rtgen.compiler.typemap.python.idl_names import distinct
from rtgen.facts.primitives import NUMBERS


class PythonType(msgspec.Struct, frozen=True):
    """The annotation of a type, and the expression of its initial value.

    `imports` are the names that both use, as (module, name); builtins have an empty module.
    """

    annotation: str
    default: str
    imports: tuple[tuple[str, str], ...] = ()


_INT = PythonType("int", "0", (("", "int"),))
_FLOAT = PythonType("float", "0.0", (("", "float"),))
_CHAR = PythonType("str", r'"\x00"', (("", "str"),))

PRIMITIVES: dict[Primitive, PythonType] = {
    **dict.fromkeys((Primitive.SHORT, Primitive.UNSIGNED_SHORT), _INT),
    **dict.fromkeys((Primitive.LONG, Primitive.UNSIGNED_LONG), _INT),
    **dict.fromkeys((Primitive.LONG_LONG, Primitive.UNSIGNED_LONG_LONG), _INT),
    **dict.fromkeys((Primitive.INT8, Primitive.UINT8, Primitive.OCTET), _INT),
    **dict.fromkeys((Primitive.FLOAT, Primitive.DOUBLE, Primitive.LONG_DOUBLE), _FLOAT),
    **dict.fromkeys((Primitive.CHAR, Primitive.WCHAR), _CHAR),
    Primitive.BOOLEAN: PythonType("bool", "False", (("", "bool"),)),
    Primitive.VOID: PythonType("None", "None"),
    Primitive.ANY: PythonType(
        "AnyValue", "AnyValue()", (("rtgen.runtime.values", "AnyValue"),)
    ),
    Primitive.TYPE_CODE: PythonType(
        "Descriptor",
        "NULL",
        (
            ("rtgen.runtime.marshalling.descriptors", "Descriptor"),
            ("rtgen.runtime.marshalling.descriptors", "NULL"),
        ),
    ),
    Primitive.OBJECT: PythonType(
        "ObjectReference | None",
        "None",
        (("rtgen.runtime.marshalling.octets", "ObjectReference"),),
    ),
    Primitive.VALUE_BASE: PythonType(
        "Value | Box | None",
        "None",
        (("rtgen.runtime.values", "Value"), ("rtgen.runtime.values", "Box")),
    ),
}
"""The basic types (OMG IDL to Python 1.3, table 1; CORBA 3.3 part 1, 7.11.1)."""

BYTES_ELEMENTS = (Primitive.OCTET, Primitive.UINT8)
"""Element types whose sequences and one-dimensional arrays are `bytes`."""

_SIGNED = frozenset(
    (Primitive.SHORT, Primitive.LONG, Primitive.LONG_LONG, Primitive.INT8)
)

STR_ELEMENTS = (Primitive.CHAR,)
"""Element types whose sequences and one-dimensional arrays are `str`."""

NameOf: TypeAlias = Callable[[ScopedName], str]
"""Function that returns the name of a declared type as written at the place of the text."""


class PythonMapping(msgspec.Struct, eq=False):
    """The Python types of type expressions; `spell` returns the name for an import.

    `spell(module, name)` returns how the name is written (it may have an alias). An object of an
    interface is a reference in data, and with `servants` the abstract servant.
    """

    model: Model
    name_of: NameOf
    spell: Callable[[str, str], str] = lambda module, name: name
    servants: bool = False
    _annotations: dict[Type, str] = {}

    def annotation(self, type_: Type) -> str:
        """Return the annotation of a value of the type, on one line."""
        text = self._annotations.get(type_)
        if text is None:
            text = self._annotations[type_] = self._annotation(type_)
        return text

    def _annotation(self, type_: Type) -> str:
        match type_:
            case PrimitiveType(kind):
                return self.spelled(PRIMITIVES[kind], PRIMITIVES[kind].annotation)
            case StringType():
                return self.spell("", "str")
            case FixedType():
                return self.spell("decimal", "Decimal")
            case SequenceType(numeric="array") | ArrayType(numeric="array"):
                inner = self.annotation(type_.element)
                return f"{self.spell('collections.abc', 'MutableSequence')}[{inner}]"
            case SequenceType(numeric="numpy") | ArrayType(numeric="numpy"):
                return f"{self.spell('numpy.typing', 'NDArray')}[{self.item(type_)}]"
            case SequenceType(element) | ArrayType(element):
                depth = len(type_.dimensions) if isinstance(type_, ArrayType) else 1
                text = self.text_type(type_)
                if text is None:
                    inner = self.annotation(element)
                else:
                    inner = self.spell("", text)
                    depth -= 1
                for _ in range(depth):
                    inner = f"{self.spell('', 'list')}[{inner}]"
                return inner
            case MapType(key, value):
                pair = f"{self.annotation(key)}, {self.annotation(value)}"
                return f"{self.spell('', 'dict')}[{pair}]"
            case NamedType(name):
                return self._named(name)

    def parameters(self, operation: Operation) -> tuple[str, ...]:
        """Return the parameters of a method: `self`, then those that are `in` or `inout`."""
        names = distinct((p.name for p in operation.parameters), ("self",))
        arguments = operation.arguments
        return "self", *(
            f"{names[p.name]}: {self.annotation(p.type)}" for p in arguments
        )

    def result(self, operation: Operation) -> str:
        """Return the result as in omniORBpy: None, a value, or a tuple, the returned one first."""
        types = [operation.returns] * (operation.returns != VOID)
        types += [parameter.type for parameter in operation.results]
        annotations = [self.annotation(type_) for type_ in types]
        if len(annotations) > 1:
            return f"{self.spell('', 'tuple')}[{', '.join(annotations)}]"
        return annotations[0] if annotations else "None"

    def immutable(self, type_: Type) -> bool:
        """Return whether values of the type can be shared, such as defaults, without copying."""
        type_ = self.model.unalias(type_)
        match type_:
            case SequenceType() | ArrayType():
                return self.is_text(type_)
            case MapType():
                return False
            case NamedType(name):
                declaration = self.model.find(name)
                return not isinstance(declaration, Struct | Union | ExceptionDecl)
        return True

    def is_text(self, type_: Type) -> bool:
        """Return whether a sequence or array is `bytes` or `str` in Python."""
        flat = not isinstance(type_, ArrayType) or len(type_.dimensions) == 1
        return flat and self.text_type(type_) is not None

    def text_type(self, type_: Type) -> str | None:
        """Return `bytes` or `str` if a sequence or the innermost dimension of an array is one."""
        if not isinstance(type_, SequenceType | ArrayType):
            return None
        element = self.model.unalias(type_.element)
        if isinstance(element, PrimitiveType):
            if element.kind in BYTES_ELEMENTS:
                return "bytes"
            if element.kind in STR_ELEMENTS:
                return "str"
        return None

    def spelled(self, basic: PythonType, text: str) -> str:
        """Return an annotation or expression of a basic type, with its names as imported."""
        for module, name in basic.imports:
            if name in text:
                text = text.replace(name, self.spell(module, name), 1)
        return text

    def _named(self, name: ScopedName) -> str:
        declaration = self.model.find(name)
        if isinstance(declaration, Interface) and self.servants:
            return f"{self.name_of(name)} | None"
        if isinstance(declaration, Interface) and declaration.abstract:
            base = self.spelled(PRIMITIVES[Primitive.VALUE_BASE], "Value | Box | None")
            reference = self.spell(
                "rtgen.runtime.marshalling.octets", "ObjectReference"
            )
            return f"{reference} | {base}"
        if isinstance(declaration, Interface):
            reference = self.spell(
                "rtgen.runtime.marshalling.octets", "ObjectReference"
            )
            return f"{reference} | None"
        if isinstance(declaration, Valuetype | ValueBox):
            return f"{self.name_of(name)} | None"
        if isinstance(declaration, Native | Component | Home):
            return self.spell("", "object")
        return self.name_of(name)

    def item(self, type_: SequenceType | ArrayType) -> str:
        """Return numpy's scalar type; for structs, that of structured arrays."""
        kind = self.number_kind(type_)
        name = "void"
        if kind is not None:
            scalar = NUMBERS[kind]
            name = "float" if kind in (Primitive.FLOAT, Primitive.DOUBLE) else "int"
            name = f"{'u' * scalar.code.isupper()}{name}{8 * scalar.size}"
        return f"{self.spell('numpy', 'numpy')}.{name}"

    def number_kind(self, type_: SequenceType | ArrayType) -> Primitive | None:
        """Return the basic type of the elements; None for others."""
        element = self.model.unalias(type_.element)
        return element.kind if isinstance(element, PrimitiveType) else None


def is_boolean(model: Model, field: Bitfield) -> bool:
    """Return whether a bitfield is a boolean (IDL 4.2, 7.4.13.4.3).

    It has one bit, and no type or `boolean`.
    """
    if field.type is None:
        return field.bits == 1
    return model.unalias(field.type) == PrimitiveType(Primitive.BOOLEAN)


def is_signed(model: Model, field: Bitfield) -> bool:
    """Return whether a bitfield is signed, in two's complement."""
    plain = None if field.type is None else model.unalias(field.type)
    return isinstance(plain, PrimitiveType) and plain.kind in _SIGNED
