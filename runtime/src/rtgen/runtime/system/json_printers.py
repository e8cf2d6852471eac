"""Compiled JSON printers of log records, cached by type.

A printer inserts the members of a value into a text. For values that violate their definition (an
enumerator in a `long`, a non-finite number), it falls back to `plain`, which supports every type
and gives the same text.
"""

from __future__ import annotations

import json
import math
from array import array
from collections.abc import Callable
from decimal import Decimal
from enum import Enum
from json.encoder import encode_basestring
from keyword import iskeyword
from typing import Any

from rtgen.facts.primitives import INTEGERS
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    BitsetDescriptor,
    DataType,
    Description,
    EnumDescriptor,
    ExceptionDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    ValueDescriptor,
)
from rtgen.runtime.marshalling.numeric import NumericArray, listed
from rtgen.runtime.values import AnyValue, Box, Value

Printer = Callable[[Any], str]

_FLOATS = ("float", "double")


def json_printer(type_: type[DataType]) -> Printer:
    """Return the printer of a type: equivalent to `json.dumps` of the result of `plain`."""
    descriptor = getattr(type_, "_descriptor_", None)
    if isinstance(descriptor, StructDescriptor):
        return _Compiler().compiled(descriptor) or _print
    return _print


def _print(value: Any) -> str:
    return json.dumps(plain(value), ensure_ascii=False)


def _octets(value: bytes) -> str:
    return repr([*value])


def _numbers(values: Any) -> str:
    if type(values) is not list:
        values = values.tolist()
    for value in values:
        kind = type(value)
        if kind is not int and (kind is not float or value - value != 0.0):
            return _print(values)
    return repr(values)


class _Compiler:
    """Compiles a function that prints a struct; structs with unsupported members have none.

    Only names of attributes are inserted into the function's text; texts are passed as values.
    """

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._checks: list[str] = []
        self._floats: list[str] = []
        self._parts: list[str] = []
        self._text = ""
        self._names: dict[str, Any] = {
            "plainly": _print,
            "quoted": encode_basestring,
            "octets": _octets,
            "numbers": _numbers,
            "empty": "[]",
            "listed": (list, NumericArray),
            "truth": ("false", "true"),
        }

    def compiled(self, struct: StructDescriptor) -> Printer | None:
        """Return the function; None for a struct with members that only `plain` supports."""
        if not self._struct(struct, "value"):
            return None
        self._end_text()
        # If the sum is not finite, a number is not finite or the sum overflows.
        total = " + ".join(self._floats)
        checks = [*self._checks, f"({total}) * 0.0 == 0.0"] if total else self._checks
        body = [
            *self._lines,
            f"if {' and '.join(checks) or 'True'}:",
            f"    return f'{''.join(self._parts)}'",
            "return plainly(value)",
        ]
        source = "def printed(value):\n" + "".join(f"    {line}\n" for line in body)
        exec(compile(source, "<json printer>", "exec"), self._names)
        printer: Printer = self._names["printed"]
        return printer

    def _end_text(self) -> None:
        if self._text:
            name = f"text{len(self._names)}"
            self._names[name] = self._text
            self._parts.append(f"{{{name}}}")
            self._text = ""

    def _struct(self, struct: StructDescriptor, owner: str) -> bool:
        self._text += "{"
        for number, member in enumerate(struct.members):
            attribute = member.attribute
            if member.optional or not attribute.isidentifier() or iskeyword(attribute):
                return False
            comma = ", " if number else ""
            self._text += f"{comma}{json.dumps(member.name, ensure_ascii=False)}: "
            name = f"v{len(self._lines)}"
            self._lines.append(f"{name} = {owner}.{attribute}")
            if not self._member(member.type, name):
                return False
        self._text += "}"
        return True

    def _member(self, type_: Description, name: str) -> bool:
        while isinstance(type_, AliasDescriptor):
            type_ = type_.target
        kind, shown = "", ""
        match type_:
            case StructDescriptor():
                return self._struct(type_, name)
            case PrimitiveDescriptor(primitive) if primitive in _FLOATS:
                kind, shown = "float", f"{name}!r"
                self._floats.append(name)
            case PrimitiveDescriptor(primitive) if primitive in INTEGERS:
                kind, shown = "int", name
            case PrimitiveDescriptor("boolean"):
                kind, shown = "bool", f"truth[{name}]"
            case StringDescriptor():
                kind, shown = "str", f"quoted({name})"
            case SequenceDescriptor(PrimitiveDescriptor("octet")):
                kind, shown = "bytes", f"octets({name})"
            case SequenceDescriptor(PrimitiveDescriptor(element)) if (
                element in _FLOATS or element in INTEGERS
            ):
                shown = f"numbers({name}) if {name} else empty"
                self._checks.append(f"type({name}) in listed")
            case _:
                return False
        if kind:
            self._checks.append(f"type({name}) is {kind}")
        self._end_text()
        self._parts.append(f"{{{shown}}}")
        return True


def plain(value: object) -> Any:
    """Convert a generated value to JSON types, with the names of its definition.

    A recursive valuetype is represented by its name.
    """
    return _plain(value, ())


def _plain(value: Any, around: tuple[int, ...]) -> Any:
    match value:
        case None | bool() | str():
            return value
        case Enum():
            return _enumerator(value)
        case int():
            return value
        case float():
            return value if math.isfinite(value) else str(value)
        case list() | tuple():
            return [_plain(item, around) for item in value]
        case dict():
            pairs = value.items()
            return [[_plain(k, around), _plain(v, around)] for k, v in pairs]
        case bytes() | bytearray():
            return list(value)
        case array():
            return _plain(value.tolist(), around)
        case Decimal() | Description():
            return str(value)
        case AnyValue():
            return _plain(value.value, around)
    dtype = getattr(value, "dtype", None)
    if dtype is not None:
        return _rows(value.tolist(), dtype)
    if hasattr(value, "__len__"):  # other buffers and collections
        return _plain(listed(value), around)
    if id(value) in around:
        return str(value.described())
    named = _members(getattr(value, "_descriptor_", None))
    inside = (*around, id(value)) if isinstance(value, Value | Box) else around
    if named:
        return {n: _plain(getattr(value, a), inside) for n, a in named.items()}
    names = getattr(type(value), "__match_args__", ("discriminator", "value"))
    return {name: _plain(getattr(value, name), inside) for name in names}


def _rows(rows: Any, dtype: Any) -> Any:
    """Return the items of a numpy array; those of a structured one by name."""
    if dtype.names is None:
        return _plain(rows, ())
    if isinstance(rows, list):
        return [_rows(row, dtype) for row in rows]
    fields = zip(dtype.names, rows, strict=True)
    return {name: _rows(item, dtype[name].base) for name, item in fields}


def _enumerator(value: Any) -> str:
    descriptor = getattr(value, "_descriptor_", None)
    if isinstance(descriptor, EnumDescriptor):
        return next(name for name, number in descriptor.members if number == value)
    return str(value.name)


def _members(descriptor: object) -> dict[str, str]:
    """Return the attributes of a generated value by name in the definition."""
    match descriptor:
        case StructDescriptor() | ExceptionDescriptor():
            return {m.name: m.attribute for m in descriptor.members}
        case ValueDescriptor():
            return {m.name: m.attribute for m in descriptor.all_members()}
        case BitsetDescriptor():
            return {f.name: f.attribute for f in descriptor.fields}
    return {}
