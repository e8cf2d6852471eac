"""Values of `@default` that are not constant expressions: of lists, and flags of a bitmask.

IDL has no literal for a list, so its default is a text, in the forms of configuration parameters
(`"1, 2"`) and of rosidl_adapter, which writes Python's (`"(1, 2)"`).
"""

from __future__ import annotations

import re
import struct
from decimal import Decimal
from math import isfinite, prod

from rtgen.compiler.frontends.idl.meaning.operands import string_size
from rtgen.compiler.frontends.idl.meaning.typetable import PRIMITIVES, Types
from rtgen.compiler.frontends.idl.names.scopes import Kind
from rtgen.compiler.frontends.idl.syntax import literals, tree
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.model import (
    ArrayType,
    ConstantValue,
    EnumeratorName,
    FixedType,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from rtgen.facts import parameter_texts
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES

_BRACKETS = (("(", ")"), ("[", "]"), ("{", "}"))
_ITEM = re.compile(
    r"""\s*(?:("(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*')\s*|([^,"']*+))(,|$)""", re.DOTALL
)
_CHARACTERS = (Primitive.CHAR, Primitive.WCHAR)
_INTEGER = PrimitiveType(Primitive.LONG_LONG)
_MAX_FLAGS = 64


class DefaultError(Exception):
    """A default that does not fit its type; `hint` says what would."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        self.hint = hint
        super().__init__(message)


def items_of(
    types: Types, type_: SequenceType | ArrayType, text: str
) -> tuple[ConstantValue, ...]:
    """Return the items of a list, those of all dimensions in a row. Raises DefaultError."""
    element = types.unaliased(type_.element)
    if isinstance(element, PrimitiveType) and element.kind in _CHARACTERS:
        items: tuple[ConstantValue, ...] = tuple(text)
        for character in text:
            if element.kind is Primitive.CHAR and ord(character) > 0xFF:
                raise DefaultError(f"{character} is not a character of ISO 8859-1")
    else:
        items = tuple(
            _item(types, element, item, quoted) for item, quoted in _split(text)
        )
    if isinstance(type_, ArrayType):
        count = prod(type_.dimensions)
        if len(items) != count:
            message = f"{len(items)} items do not fill {type_}, which has {count}"
            raise DefaultError(message, f"write {count} items")
    elif type_.bound is not None and len(items) > type_.bound:
        message = f"{len(items)} items do not fit into {type_}"
        raise DefaultError(message, "leave some out, or raise the bound")
    return items


def flags_of(types: Types, type_: NamedType, value: tree.Expression) -> int:
    """Return the number of the flags in an expression `A | B`, or a number itself.

    Raises DefaultError.
    """
    match value:
        case tree.Group(inner):
            return flags_of(types, type_, inner)
        case tree.Chain(first, rest) if all(operator == "|" for operator, _ in rest):
            flags = flags_of(types, type_, first)
            for _, operand in rest:
                flags |= flags_of(types, type_, operand)
            return flags
        case tree.ScopedName(parts):
            return _flag(types, type_, parts[-1].text)
        case tree.Number(text):
            return _flag(types, type_, text)
    names = [member.name.text for member in _members(types, type_)]
    raise DefaultError("this is not a set of flags", f"write {' | '.join(names[:2])}")


def enumerator_of(types: Types, type_: NamedType, name: str) -> EnumeratorName | None:
    """Return the enumerator of an enum by its unscoped name, or None."""
    for member in _members(types, type_):
        if member.name.text == name:
            return EnumeratorName((*type_.name[:-1], name))
    return None


def words_of(types: Types, type_: Type) -> tuple[str, ...]:
    """Return the words that denote values of a type: of an enum, a bitmask or a truth value."""
    plain = types.unaliased(type_)
    if isinstance(plain, NamedType):
        return tuple(member.name.text for member in _members(types, plain))
    return ("TRUE", "FALSE") if plain == PRIMITIVES[Primitive.BOOLEAN] else ()


def _members(types: Types, type_: NamedType) -> tuple[tree.Enumerator, ...]:
    """Return the members of an enum or bitmask; none for other types."""
    entity = types.entity(type_.name)
    node = None if entity is None else entity.node
    return node.members if isinstance(node, tree.Enum) else ()


def _flag(types: Types, type_: NamedType, text: str) -> int:
    """Return the number of a flag by its name, or a number."""
    entity = types.entity(type_.name)
    assert entity is not None
    names = []
    position = 0
    for member in _members(types, type_):
        for annotation in member.annotations:
            if annotation.name == "position" and annotation.arguments:
                value = annotation.arguments[0].value
                bits = types.constants.evaluate(value, _INTEGER, entity.unit)
                position = bits if isinstance(bits, int) else position
        if member.name.text == text:
            return 1 << position
        names.append(member.name.text)
        position += 1
    number = _number(text)
    if isinstance(number, int):
        if not 0 <= number < 1 << _MAX_FLAGS:
            raise DefaultError(f"{text} has more than {_MAX_FLAGS} bits")
        return number
    near = nearest(text, names)
    raise DefaultError(f"{type_} has no flag {text}", near and f"did you mean {near}?")


def _split(text: str) -> list[tuple[str, bool]]:
    """Return the items of a text, and whether each was in quotes. Raises DefaultError."""
    inner = text.strip()
    for opening, closing in _BRACKETS:
        if inner.startswith(opening):
            if not inner.endswith(closing) or len(inner) < 2:
                raise DefaultError(f"'{opening}' is not closed")
            # Python writes a comma after the only item of a tuple.
            inner = inner[1:-1].strip().removesuffix(",")
            break
    items: list[tuple[str, bool]] = []
    at = 0
    while inner:
        match = _ITEM.match(inner, at)
        if match is None:
            raise DefaultError("a quote is not where an item begins or ends")
        quoted, plain, comma = match.groups()
        is_quoted = quoted is not None
        items.append((_unquoted(quoted) if is_quoted else plain.strip(), is_quoted))
        if not comma:
            break
        at = match.end()
    return items


def _unquoted(item: str) -> str:
    try:
        return literals.text((f'L"{item[1:-1]}"',), False).value
    except literals.LiteralError as error:
        raise DefaultError(str(error), error.hint) from None


def _item(types: Types, element: Type | None, text: str, quoted: bool) -> ConstantValue:
    """Return an item of a list as a value of the element's type."""
    match element:
        case StringType():
            if element.bound is not None and string_size(element, text) > element.bound:
                message = f"'{text}' does not fit into {element}"
                raise DefaultError(message, "shorten it, or raise the bound")
            return text
        case _ if quoted:
            raise DefaultError(f"'{text}' is not a value of {element}")
        case PrimitiveType(Primitive.BOOLEAN):
            try:
                return parameter_texts.boolean(text)
            except ValueError:
                raise DefaultError(f"{text} is neither true nor false") from None
        case PrimitiveType(kind) if kind in INTEGER_RANGES:
            return _integer(kind, text)
        case PrimitiveType(kind) if kind in FLOAT_LIMITS:
            return _real(kind, text)
        case FixedType(digits, scale):
            return _fixed(digits, scale, text)
        case NamedType():
            return _named(types, element, text)
    raise DefaultError(
        f"no default can be given for items of {element}", "leave it out"
    )


def _number(text: str) -> int | float | Decimal | None:
    sign = -1 if text.startswith("-") else 1
    try:
        return sign * literals.number(text[text[:1] in ("-", "+") :].strip())
    except literals.LiteralError:
        return None


def _integer(kind: Primitive, text: str) -> int:
    number = _number(text)
    low, high = INTEGER_RANGES[kind]
    if not isinstance(number, int):
        raise DefaultError(f"{text or 'an empty item'} is not a whole number")
    if not low <= number <= high:
        raise DefaultError(f"{text} is out of the range of {kind}: {low} to {high}")
    return number


def _real(kind: Primitive, text: str) -> float:
    try:
        number = parameter_texts.number(text)
    except ValueError:
        raise DefaultError(f"{text or 'an empty item'} is not a number") from None
    if isfinite(number) and abs(number) > FLOAT_LIMITS[kind]:
        raise DefaultError(f"{text} is beyond the range of a {kind}")
    return shortest(number) if kind is Primitive.FLOAT else number


def shortest(value: float) -> float:
    """Return the shortest decimal number that rounds to this one in single precision."""
    packed = struct.pack("<f", value)
    for digits in range(1, 9):
        short = float(f"{value:.{digits}g}")
        if struct.pack("<f", short) == packed:
            return short
    return value


def _fixed(digits: int, scale: int, text: str) -> Decimal:
    number = _number(text if text[-1:] in ("d", "D") else f"{text}d")
    if not isinstance(number, Decimal):
        raise DefaultError(f"{text or 'an empty item'} is not a fixed-point number")
    whole = number.scaleb(scale)
    if whole != whole.to_integral_value() or abs(whole) >= 10**digits:
        raise DefaultError(f"{text} does not fit into fixed<{digits},{scale}>")
    return number


def _named(types: Types, element: NamedType, text: str) -> ConstantValue:
    """Return an enumerator by its name, or the flags of a bitmask."""
    kind = types.kind_of(element)
    if kind is Kind.BITMASK:
        number = 0
        for part in text.split("|"):
            number |= _flag(types, element, part.strip())
        return number
    if kind is not Kind.ENUM:
        raise DefaultError(
            f"no default can be given for items of {element}",
            "give the members of their type defaults",
        )
    name = text.rpartition("::")[2]
    enumerator = enumerator_of(types, element, name)
    if enumerator is None:
        names = [member.name.text for member in _members(types, element)]
        near = nearest(name, names)
        hint = f"did you mean {near}?" if near else f"it has {', '.join(names[:9])}"
        raise DefaultError(f"{name} is not an enumerator of {element}", hint)
    return enumerator
