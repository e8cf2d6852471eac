"""Values of TECS functions as JSON and back (the form `opaque-rpc-trace/1`).

Numbers and characters are numbers; texts have one character for each code unit; `inf`, `-inf` and
`nan` are texts; arrays are lists; structs are objects; the target of a plain pointer in a struct
is a list of one element; NULL is null. A nullable `out` parameter is an argument: null, or
`{"want": true}`.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import TypeAlias

from rtgen.compiler.layouts.tdr import (
    Basic,
    Counted,
    FixedArray,
    Item,
    Node,
    Nothing,
    Octets,
    Record,
    String,
)
from rtgen.compiler.typemap.tecs.python import member_name, struct_class
from rtgen.facts.tdr import Scalar

Json: TypeAlias = (
    bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"] | None
)

_FLOATS = (Scalar.FLOAT32, Scalar.DOUBLE64)
_LAST_CHARACTER = 0x10FFFF
_LAST_UTF16 = 0xFFFF


class JsonError(ValueError):
    """JSON that is not a value of the type; the message names the place."""


def to_json(node: Node, value: object) -> Json:
    """Convert a value to JSON."""
    match node:
        case Basic(scalar):
            return _number_to_json(scalar, value)
        case Octets(scalar):
            return _octets_to_json(scalar, value)
        case Counted(element) if node.is_octets and isinstance(element, Basic):
            return _octets_to_json(element.scalar, value)
        case FixedArray(element) | Counted(element):
            assert isinstance(value, list | tuple)
            return [to_json(element, each) for each in value]
        case String():
            return _text_to_json(node, value)
        case Record(items=items):
            return {
                item.name: _member_to_json(item, getattr(value, member_name(item.name)))
                for item in items
            }
    return None


def item_to_json(item: Item, value: object) -> Json:
    """Convert the value of a parameter to JSON."""
    return None if value is None else to_json(item.node, value)


def arguments_to_json(items: Sequence[Item], values: Sequence[object]) -> Json:
    """Convert the arguments of a request to JSON."""
    arguments: dict[str, Json] = {}
    for item, value in zip(items, values, strict=True):
        if item.asked:
            arguments[item.name] = {"want": True} if value else None
        else:
            arguments[item.name] = item_to_json(item, value)
    return arguments


def _member_to_json(item: Item, value: object) -> Json:
    inner = to_json(item.node, value)
    return [inner] if item.pointer and not isinstance(item.node, Nothing) else inner


def _number_to_json(scalar: Scalar, value: object) -> Json:
    if scalar is Scalar.BOOL:
        return bool(value)
    if scalar not in _FLOATS:
        assert isinstance(value, int)
        return int(value)
    assert isinstance(value, int | float)
    if math.isfinite(value):
        return float(value)
    return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"


def _octets_to_json(scalar: Scalar, value: object) -> Json:
    assert isinstance(value, bytes)
    if scalar is Scalar.SCHAR:
        return [octet - 256 if octet > 127 else octet for octet in value]
    return list(value)


def _text_to_json(node: String, value: object) -> Json:
    if isinstance(value, str):
        return value
    assert isinstance(value, list)
    units = [unit & _mask(node) for unit in value]
    if any(unit > _LAST_CHARACTER for unit in units):
        return list(value)
    text = "".join(map(chr, units))
    return _from_utf16(text) if _mask(node) == _LAST_UTF16 else text


def _from_utf16(text: str) -> str:
    """Join surrogate pairs into single characters, as JSON parsers do."""
    return text.encode("utf-16-le", "surrogatepass").decode(
        "utf-16-le", "surrogatepass"
    )


def _to_utf16(text: str) -> list[int]:
    """Return the UTF-16 code units; a character beyond the BMP has two."""
    data = text.encode("utf-16-le", "surrogatepass")
    return list(struct.unpack(f"<{len(data) // 2}H", data))


def _mask(node: String) -> int:
    return (1 << 8 * struct.calcsize(node.kind)) - 1


def from_json(node: Node, value: Json, types: ModuleType, place: str) -> object:
    """Convert JSON to a value; `types` has the classes of structs. Raises JsonError."""
    match node:
        case Basic(scalar):
            return _number_from_json(scalar, value, place)
        case Octets() | Counted() if isinstance(node, Octets) or node.is_octets:
            return _octets_from_json(value, place)
        case FixedArray(element) | Counted(element):
            return [
                from_json(element, each, types, f"{place}[{i}]")
                for i, each in enumerate(_list(value, place))
            ]
        case String():
            return _text_from_json(node, value, place)
        case Record(record, items):
            return _record_from_json(record.name, items, value, types, place)
    return None


def item_from_json(item: Item, value: Json, types: ModuleType) -> object:
    """Convert JSON to the value of a parameter, None for NULL. Raises JsonError."""
    if value is None and item.nullable:
        return None
    return from_json(item.node, value, types, item.name)


def arguments_from_json(
    items: Sequence[Item], value: Json, types: ModuleType
) -> tuple[object, ...]:
    """Convert JSON to the arguments of a request. Raises JsonError."""
    values = _object(value, "arguments", {item.name: item for item in items})
    return tuple(
        (
            _is_requested(values[item.name], item.name)
            if item.asked
            else item_from_json(item, values[item.name], types)
        )
        for item in items
    )


def outs_from_json(
    items: Sequence[Item], value: Json, types: ModuleType
) -> tuple[object, ...]:
    """Convert JSON to the outs of a reply; omitted and null outs become None if allowed.

    Raises JsonError.
    """
    values = _object(value, "outs", {item.name: item for item in items})
    return tuple(
        (
            None
            if item.nullable and values[item.name] is None
            else from_json(item.node, values[item.name], types, item.name)
        )
        for item in items
    )


def _is_requested(value: Json, place: str) -> bool:
    if value is None:
        return False
    if isinstance(value, Mapping) and value.get("want") is True:
        return True
    raise JsonError(f'{place}: null, or {{"want": true}}')


def _object(value: Json, place: str, items: Mapping[str, Item]) -> dict[str, Json]:
    """Return the members of a JSON object by name; members without octets may be omitted."""
    if not isinstance(value, Mapping):
        raise JsonError(f"{place}: an object is needed")
    unknown = [name for name in value if name not in items]
    if unknown:
        names = ", ".join(items) or "none"
        raise JsonError(f"{place}: {unknown[0]!r} is unknown; known: {names}")
    missing = [
        name
        for name, item in items.items()
        if name not in value and not isinstance(item.node, Nothing)
    ]
    if missing:
        raise JsonError(f"{place}: {missing[0]!r} is missing")
    return {name: value.get(name) for name in items}


def _record_from_json(
    tag: tuple[str, ...],
    items: Sequence[Item],
    value: Json,
    types: ModuleType,
    place: str,
) -> object:
    entries = _object(value, place, {item.name: item for item in items})
    values = []
    for item in items:
        inner = entries[item.name]
        if item.pointer and isinstance(inner, list) and len(inner) == 1:
            inner = inner[0]
        path = f"{place}.{item.name}"
        values.append(from_json(item.node, inner, types, path))
    return getattr(types, struct_class(tag))(*values)


def _number_from_json(scalar: Scalar, value: Json, place: str) -> object:
    if scalar is Scalar.BOOL:
        if isinstance(value, bool) or value in (0, 1):
            return bool(value)
        raise JsonError(f"{place}: true or false is needed")
    if scalar in _FLOATS:
        if value in ("inf", "-inf", "nan"):
            return float(str(value))
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
        raise JsonError(f"{place}: a number is needed")
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    if isinstance(value, float) and value.is_integer():
        return int(value)
    raise JsonError(f"{place}: an integer is needed")


def _octets_from_json(value: Json, place: str) -> bytes:
    octets = []
    for each in _list(value, place):
        if not isinstance(each, int) or not -128 <= each <= 255:
            raise JsonError(f"{place}: {each!r} is not an octet")
        octets.append(each & 0xFF)
    return bytes(octets)


def _text_from_json(node: String, value: Json, place: str) -> object:
    if not node.is_wide:
        if isinstance(value, str):
            return value
        raise JsonError(f"{place}: a text is needed")
    units: Sequence[Json]
    if not isinstance(value, str):
        units = _list(value, place)
    elif _mask(node) == _LAST_UTF16:
        units = _to_utf16(value)
    else:
        units = [ord(character) for character in value]
    low = -(_mask(node) + 1) // 2 if node.kind.islower() else 0
    characters = []
    for unit in units:
        if not isinstance(unit, int) or not low <= unit <= _mask(node):
            raise JsonError(f"{place}: {unit!r} is not a code unit")
        wrapped = unit > _mask(node) // 2 and node.kind.islower()
        characters.append(unit - _mask(node) - 1 if wrapped else unit)
    return characters


def _list(value: Json, place: str) -> Sequence[Json]:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return value
    raise JsonError(f"{place}: a list is needed")
