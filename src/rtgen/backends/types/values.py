"""How single values are converted: an expression for its atom, and the way back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rtgen.backends.types.scope import Scope
from rtgen.layouts.cdr import Atom, Dynamic, Form, Text
from rtgen.model import NamedType, Primitive, PrimitiveType, Type


@dataclass(frozen=True, slots=True)
class Tables:
    """The lookup tables of enums that a module's codecs need: enum class to table name."""

    scope: Scope
    enums: dict[str, str]
    describe: Callable[[Type], str]

    def dynamic(self, node: Dynamic) -> str:
        """The descriptor of what is marshalled along it, for a statement in a function."""
        if isinstance(node.type, NamedType):
            return f"{self.scope.reference(node.type.name)}._descriptor_"
        if node.type == PrimitiveType(Primitive.ANY):
            return self.scope.ANY
        return self.describe(node.type)

    def table(self, atom: Atom) -> str:
        """The table of an enum's members by number."""
        assert atom.name is not None
        enum = self.scope.reference(atom.name)
        return self.enums.setdefault(enum, f"_{enum}_members")

    def packed(self, atom: Atom, value: str) -> str:
        """The expression that `struct` packs for a value."""
        py = self.scope
        match atom.form:
            case Form.BOOLEAN:
                return f"{py.BOOLEAN}[{value}]"
            case Form.ENUMERATOR:
                return f"{self.table(atom)}[{value}]"
            case Form.CHARACTER:
                return f'{value}.encode("latin-1")'
            case Form.WIDE_CHARACTER:
                return f"{py.wide_character}({value})"
            case Form.QUAD:
                return f"{py.quad_octets}({value}, little_endian)"
            case Form.FIXED:
                return f"{py.fixed_octets}({value}, {atom.digits}, {atom.scale})"
            case Form.FLAGS if atom.digits != 8 * atom.size:
                assert atom.name is not None
                return f"{py.flags_number}({value}, {atom.digits})"
            case Form.BITS:
                return f"{value}.to_number()"
        return value

    def unpacked(self, atom: Atom, raw: str) -> str:
        """The value of what `struct` unpacked."""
        py = self.scope
        match atom.form:
            case Form.BOOLEAN:
                return f"{py.BOOLEAN}[{raw}]"
            case Form.ENUMERATOR:
                return f"{self.table(atom)}[{raw}]"
            case Form.CHARACTER:
                return f'{raw}.decode("latin-1")'
            case Form.WIDE_CHARACTER:
                return f"{py.wide_character_value}({raw})"
            case Form.QUAD:
                return f"{py.quad_value}({raw}, little_endian)"
            case Form.FIXED:
                return f"{py.fixed_value}({raw}, {atom.digits}, {atom.scale})"
            case Form.FLAGS:
                assert atom.name is not None
                flags = py.reference(atom.name)
                if atom.digits == 8 * atom.size:
                    return f"{flags}({raw})"
                return f"{flags}({py.flags_number}({raw}, {atom.digits}))"
            case Form.BITS:
                assert atom.name is not None
                return f"{py.reference(atom.name)}.from_number({raw})"
        return raw

    def packed_text(self, text: Text, value: str) -> str:
        """The octets of a text or of octets."""
        py = self.scope
        conversions: dict[Text, str] = {
            Text.OCTETS: value,
            Text.CHARACTERS: f'{value}.encode("latin-1")',
        }
        if text in conversions:
            return conversions[text]
        function = py.text_octets if text is Text.STRING else py.wide_octets
        return f"{function}({value})"

    def unpacked_text(self, text: Text, raw: str, bound: int | None = None) -> str:
        """The way back; `bound` is that of a wide string, whose mark can be missing."""
        py = self.scope
        if text is Text.OCTETS:
            return raw
        if text is Text.CHARACTERS:
            return f'{raw}.decode("latin-1")'
        if text is Text.STRING:
            return f"{py.text_value}({raw})"
        return f"{py.wide_value}({raw}{'' if bound is None else f', {bound}'})"


def each(convert: Callable[[Atom, str], str], atom: Atom, items: str) -> str | None:
    """A list of the converted items, or None if nothing has to be converted."""
    converted = convert(atom, "item")
    return None if converted == "item" else f"[{converted} for item in {items}]"
