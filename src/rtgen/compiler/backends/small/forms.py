"""Small forms of types: which types have one, and the code of members."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite

import msgspec

from rtgen.compiler.backends.kit.quoting.python import number_literal, string_literal
from rtgen.compiler.layouts.cdr_types import enum_code
from rtgen.compiler.model import (
    ArrayType,
    ConstantValue,
    Enum,
    EnumeratorName,
    InitialValue,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
)
from rtgen.compiler.model.initial import default_of
from rtgen.facts.primitives import NUMBERS

_OCTETS = (PrimitiveType(Primitive.OCTET), PrimitiveType(Primitive.UINT8))


class NoFormError(Exception):
    """A type without a small form; the text names the offending part."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Capacity of unbounded sequences and strings, and of the buffers of ports."""

    sequence: int = 1024
    string: int = 128
    buffer: int = 2


@dataclass(frozen=True, slots=True)
class Form:
    """Code for a member; `{0}` is the attribute, `{1}` that of the source.

    `made` is the initial value of a new object; an argument is copied into a mutable one, or else
    `items`, the default of a list.
    """

    made: str
    mutable: bool
    copy: str
    put: tuple[str, ...]
    take: tuple[str, ...]
    items: str = ""


class Forms(msgspec.Struct, eq=False):
    """The forms of a model's types. `class_name` returns the class of a struct or enum."""

    _model: Model
    _limits: Limits
    _classes: dict[ScopedName, str]

    def form(self, type_: Type, own: InitialValue | None = None) -> Form:
        """Return the form of a member; `own` is its default. Raises NoFormError."""
        form = self._form(self._model.unalias(type_))
        default = default_of(self._model, type_, own)
        if default is None:
            return form
        if not isinstance(default, tuple):
            if isinstance(default, str):
                self._fits(type_, len(default.encode()), self._limits.string)
            return replace(form, made=self._literal(default))
        self._fits(type_, len(default), self._limits.sequence)
        items = ", ".join(map(self._literal, default))
        if form.mutable:
            return replace(form, items=f"({items},)" if default else "")
        return replace(form, made=f"bytes([{items}])")

    def _fits(self, type_: Type, size: int, room: int) -> None:
        plain = self._model.unalias(type_)
        bound = getattr(plain, "bound", None)
        if not isinstance(plain, ArrayType) and size > (bound or room):
            raise NoFormError(f"the default of {type_}, which is longer than {room}")

    def _literal(self, value: ConstantValue) -> str:
        """Return the literal of a default; enumerators are numbers."""
        match value:
            case EnumeratorName(name):
                return str(self._model.enumerator(name).value)
            case str():
                return string_literal(value)
            case float() if not isfinite(value):
                return f'float("{value}")'
            case bool() | int() | float():
                return number_literal(value)
        raise NoFormError(f"the default {value}")

    def _form(self, type_: Type) -> Form:
        match type_:
            case PrimitiveType(Primitive.BOOLEAN):
                return _plain(
                    "False",
                    'wire.put("<B", 1, 1 if {0} else 0)',
                    "{0} = wire.take_boolean()",
                )
            case PrimitiveType(Primitive.CHAR):
                return _plain(
                    r'"\x00"',
                    'wire.put("<B", 1, ord({0}))',
                    '{0} = chr(wire.take("<B", 1))',
                )
            case PrimitiveType(kind) if kind in NUMBERS:
                code, size, _ = NUMBERS[kind]
                zero = "0.0" if code in "fd" else "0"
                return _plain(zero, *_number(code, size))
            case StringType(wide=False, bound=bound):
                most = bound or self._limits.string
                return Form(
                    '""',
                    False,
                    f"{{0}} = _bounded({{1}}, {most})",
                    (f"wire.put_string(_bounded({{0}}, {most}))",),
                    (f"{{0}} = wire.take_string({most})",),
                )
            case NamedType(name):
                return self._named(name)
            case SequenceType(element, bound):
                return self._sequence(element, bound or self._limits.sequence)
            case ArrayType(element, (length,)):
                return self._array(element, length)
            case _:
                raise NoFormError(str(type_))

    def _named(self, name: ScopedName) -> Form:
        match self._model.find(name):
            case Enum() as enum:
                first = str(enum.initial.value)
                return _plain(first, *_number(enum_code(enum), 4))
            case Struct():
                return Form(
                    f"{self._classes[name]}()",
                    True,
                    "{0}._copy_({1})",
                    ("{0}._put_(wire)",),
                    ("{0}._take_(wire)",),
                )
            case _:
                raise NoFormError("::".join(name))

    def _sequence(self, element: Type, room: int) -> Form:
        element = self._model.unalias(element)
        if element in _OCTETS:
            return Form(
                'b""',
                False,
                f"{{0}} = _bounded({{1}}, {room})",
                (
                    f'wire.put("<I", 4, len(_bounded({{0}}, {room})))',
                    "wire.put_octets({0})",
                ),
                (f"{{0}} = wire.take_octets(wire.take_count({room}))",),
            )
        item_type, item_put, item_take = self._items(element, room, "")
        return Form(
            item_type,
            True,
            "_copy_items({0}, {1})",
            (
                'wire.put("<I", 4, len({0}))',
                "for i in range(len({0})):",
                f"    {item_put}",
            ),
            (
                f"count = wire.take_count({room})",
                "{0}.clear()",
                "for _ in range(count):",
                f"    {item_take}",
            ),
        )

    def _array(self, element: Type, length: int) -> Form:
        default = default_of(self._model, element)
        assert not isinstance(default, tuple)
        first = "" if default is None else self._literal(default)
        element = self._model.unalias(element)
        if element in _OCTETS:
            return Form(
                f"bytes([{first}] * {length})" if first else f"bytes({length})",
                False,
                f"{{0}} = _exactly({{1}}, {length})",
                (f"wire.put_octets(_exactly({{0}}, {length}))",),
                (f"{{0}} = wire.take_octets({length})",),
            )
        item_type, item_put, item_take = self._items(
            element, length, f", {length}", first
        )
        set_ = item_take.replace("{0}.next_free()", "{0}[i]")
        if set_.startswith("{0}.append("):
            value = set_.removeprefix("{0}.append(").removesuffix(")")
            set_ = f"{{0}}[i] = {value}"
        return Form(
            item_type,
            True,
            "_copy_array({0}, {1})",
            (f"for i in range({length}):", f"    {item_put}"),
            (f"for i in range({length}):", f"    {set_}"),
        )

    def _items(
        self, element: Type, room: int, length: str, first: str = ""
    ) -> tuple[str, str, str]:
        """Return the code of a list that starts with `length` items, equal to `first`."""
        match element:
            case PrimitiveType(Primitive.BOOLEAN):
                start = f", {int(first == 'True')}" if first else ""
                return (
                    f'_Numbers("B", {room}{length}{start})',
                    'wire.put("<B", 1, 1 if {0}[i] else 0)',
                    "{0}.append(wire.take_boolean())",
                )
            case PrimitiveType(kind) if kind in NUMBERS:
                code, size, _ = NUMBERS[kind]
            case NamedType(name) if isinstance(enum := self._model.find(name), Enum):
                code, size = enum_code(enum), 4
                if length and not first and enum.initial.value:
                    first = str(enum.initial.value)
            case NamedType(name) if isinstance(self._model.find(name), Struct):
                return (
                    f"_Values({self._classes[name]}, {room}{length})",
                    "{0}[i]._put_(wire)",
                    "{0}.next_free()._take_(wire)",
                )
            case StringType(wide=False, bound=bound) if not length:
                most = bound or self._limits.string
                return (
                    f"_Values(None, {room}, 0, {most})",
                    "wire.put_string({0}[i])",
                    f"{{0}}.append(wire.take_string({most}))",
                )
            case _:
                raise NoFormError(f"items of {element}")
        start = f", {first}" if first else ""
        return (
            f'_Numbers("{code}", {room}{length}{start})',
            f'wire.put("<{code}", {size}, {{0}}[i])',
            f'{{0}}.append(wire.take("<{code}", {size}))',
        )


def reachable(model: Model, name: ScopedName) -> list[ScopedName]:
    """Return the structs and enums used by a type, itself last. Raises NoFormError.

    Recursive types have no form.
    """
    names: dict[ScopedName, bool] = {}
    _reach(model, name, names)
    return list(names)


def _reach(model: Model, name: ScopedName, names: dict[ScopedName, bool]) -> None:
    """Add a type after those that it uses; types in progress are False."""
    if names.get(name) is False:
        raise NoFormError(f"{'::'.join(name)}, which holds itself")
    if name in names:
        return
    names[name] = False
    declaration = model.find(name)
    if isinstance(declaration, Struct):
        for member in model.members(declaration):
            type_ = model.unalias(member.type)
            if isinstance(type_, SequenceType | ArrayType):
                type_ = model.unalias(type_.element)
            if isinstance(type_, NamedType):
                _reach(model, type_.name, names)
    del names[name]
    names[name] = True


def _plain(type_text: str, put: str, take: str) -> Form:
    return Form(type_text, False, "{0} = {1}", (put,), (take,))


def _number(code: str, size: int) -> tuple[str, str]:
    return (
        f'wire.put("<{code}", {size}, {{0}})',
        f'{{0}} = wire.take("<{code}", {size})',
    )
