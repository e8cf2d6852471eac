"""Conversions of single values: the expression that encodes a value, and its inverse."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtgen.runtime.marshalling.descriptors import EnumDescriptor
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    Form,
    Text,
)
from rtgen.runtime.marshalling.octets import (
    BOOLEAN,
    fixed_octets,
    fixed_value,
    flags_number,
    quad_octets,
    quad_value,
    text_octets,
    text_value,
    unit_character,
    unit_number,
    unit_octets,
    unit_text,
    wide_character,
    wide_character_value,
    wide_octets,
    wide_value,
    words_of,
    words_text,
)
from rtgen.runtime.marshalling.source.text import Namespace


class Conversions:
    """Generates the conversions of single values."""

    def __init__(self, namespace: Namespace) -> None:
        self._namespace = namespace

    def _name(self, function: Callable[..., object]) -> str:
        return self._namespace.bind(function.__name__, function)

    def _boolean(self) -> str:
        return self._namespace.bind("BOOLEAN", BOOLEAN)

    def made(self, descriptor: Any) -> str:
        """Return the class of the type's values."""
        class_ = descriptor.class_
        return self._namespace.bind(class_.__name__, class_)

    def _members(self, atom: Atom) -> str:
        """Return the table of an enum's members by number, which rejects other numbers."""
        table = enumerators(atom.type)
        return self._namespace.bind(f"{atom.type.class_.__name__}_members", table)

    def packed(self, atom: Atom, value: str) -> str:
        """Return the expression for the item that `struct` packs for a value."""
        name = self._name
        match atom.form:
            case Form.BOOLEAN:
                return f"{self._boolean()}[{value}]"
            case Form.ENUMERATOR:
                return f"{self._members(atom)}[{value}]"
            case Form.CHARACTER:
                return f'{value}.encode("latin-1")'
            case Form.WIDE_CHARACTER:
                return f"{name(wide_character)}({value})"
            case Form.UNIT:
                return f"{name(unit_number)}({value})"
            case Form.QUAD:
                return f"{name(quad_octets)}({value}, little_endian)"
            case Form.FIXED:
                return f"{name(fixed_octets)}({value}, {atom.digits}, {atom.scale})"
            case Form.FLAGS if atom.digits != 8 * atom.size:
                return f"{name(flags_number)}({value}, {atom.digits})"
            case Form.BITS:
                return f"{value}.to_number()"
        return value

    def unpacked(self, atom: Atom, raw: str) -> str:
        """Return the expression for the value of an item that `struct` unpacked."""
        name = self._name
        match atom.form:
            case Form.BOOLEAN:
                return f"{self._boolean()}[{raw}]"
            case Form.ENUMERATOR:
                return f"{self._members(atom)}[{raw}]"
            case Form.CHARACTER:
                return f'{raw}.decode("latin-1")'
            case Form.WIDE_CHARACTER:
                return f"{name(wide_character_value)}({raw})"
            case Form.UNIT:
                return f"{name(unit_character)}({raw})"
            case Form.QUAD:
                return f"{name(quad_value)}({raw}, little_endian)"
            case Form.FIXED:
                return f"{name(fixed_value)}({raw}, {atom.digits}, {atom.scale})"
            case Form.FLAGS:
                flags = self.made(atom.type)
                if atom.digits == 8 * atom.size:
                    return f"{flags}({raw})"
                return f"{flags}({name(flags_number)}({raw}, {atom.digits}))"
            case Form.BITS:
                return f"{self.made(atom.type)}.from_number({raw})"
        return raw

    def packed_text(self, text: Text, value: str) -> str:
        """Return the expression for the octets of a string or an octet sequence."""
        name = self._name
        conversions: dict[Text, str] = {
            Text.OCTETS: value,
            Text.CHARACTERS: f'{value}.encode("latin-1")',
        }
        if text in conversions:
            return conversions[text]
        if text is Text.UNITS:
            return f"{name(unit_octets)}({value}, little_endian)"
        if text is Text.STRING:
            refused = f"{name(text_octets)}({value})"
            return f'{value}.encode() if "\\0" not in {value} else {refused}'
        return f"{name(wide_octets)}({value})"

    def unpacked_text(self, text: Text, raw: str, bound: int | None = None) -> str:
        """Inverse of `packed_text`; `bound` is that of a wide string, whose BOM is optional."""
        name = self._name
        if text is Text.OCTETS:
            return raw
        if text is Text.CHARACTERS:
            return f'{raw}.decode("latin-1")'
        if text is Text.STRING:
            return f"{name(text_value)}({raw})"
        if text is Text.UNITS:
            return f"{name(unit_text)}({raw}, little_endian)"
        return f"{name(wide_value)}({raw}{'' if bound is None else f', {bound}'})"

    def words(self, value: str) -> str:
        """Return the expression for the units of a wide string in ROS 2."""
        return f"{self._name(words_of)}({value})"

    def worded(self, raw: str) -> str:
        """Inverse of `words`."""
        return f"{self._name(words_text)}({raw})"

    def unpacked_string(self, raw: str, last: str) -> str:
        """Return the expression for a string from its octets and the last one, which is NUL."""
        # Same as `text_value`, inlined because of the cost of calls; that is called to raise.
        refused = f"{self._name(text_value)}({raw} + bytes([{last}]))"
        return f"{raw}.decode() if not {last} and 0 not in {raw} else {refused}"


def enumerators(descriptor: EnumDescriptor) -> dict[int, Any]:
    """Return the members of an enum by number."""
    table: dict[int, Any] | None = descriptor.codecs.get("members")
    if table is None:
        members = (descriptor.class_(number) for _, number in descriptor.members)
        table = descriptor.codecs["members"] = {m.value: m for m in members}
    return table


def each(convert: Callable[[Atom, str], str], atom: Atom, items: str) -> str | None:
    """Return a list of the converted items; None if they need no conversion."""
    converted = convert(atom, "item")
    return None if converted == "item" else f"[{converted} for item in {items}]"
