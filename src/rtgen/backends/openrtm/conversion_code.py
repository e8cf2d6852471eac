"""Prints code that converts values to omniORB's objects and back.

Structs are filled field by field: a reused object, or a new one made without its constructor,
because calls of constructors dominate the time. Nested structs are converted in place up to
`_INLINE` fields; beyond that, and for the items of sequences, by calls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from msgspec.structs import replace

from rtgen.backends.kit.quoting.python import number_literal, string_literal
from rtgen.backends.openrtm.classic import Classic
from rtgen.backends.openrtm.wire_names import WireNames, mangled
from rtgen.backends.openrtm.wire_scope import WireScope
from rtgen.facts.primitives import NUMBERS, OCTET_TYPES
from rtgen.model import (
    ArrayType,
    Case,
    ConstantValue,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    FixedType,
    Interface,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.model.declarations import OPAQUE

_INLINE = 48
"""Maximum number of fields, including those of nested structs, converted in one function."""

STAND_IN = "opaque"
"""The only member, an octet, of the placeholder of an unknown struct."""

_IN_BUFFERS = {*NUMBERS, Primitive.BOOLEAN} - OCTET_TYPES
"""The basic types whose collections are also buffers in rtgen, and lists in omniORBpy."""

_BY_OCTETS = {
    Primitive.ANY: "ANYTHING",
    Primitive.TYPE_CODE: "TYPE_CODE",
    Primitive.OBJECT: "OBJECT",
    Primitive.VALUE_BASE: "VALUE",
}


class _Convert(Protocol):
    def __call__(self, type_: Type, expression: str, depth: int = 1) -> str: ...


@dataclass(frozen=True, slots=True)
class _Field:
    """A member on both sides."""

    ours: str
    theirs: str
    type: Type


class ConversionCode:
    """Writes conversions into a module."""

    def __init__(
        self, model: Model, names: WireNames, classic: Classic, scope: WireScope
    ) -> None:
        self._model = model
        self._names = names
        self._classic = classic
        self._py = scope
        self._sizes: dict[ScopedName, int] = {}

    # Structs, exceptions, unions: bodies of functions.

    def fill(self, declaration: Struct | Union) -> list[str]:
        """Return the body of the function that fills `wire` in place from `value`."""
        if self._holds_values(declaration):
            fresh = f"{self._py.octets(declaration)}.to(value)"
            return [f"wire.__dict__.update({fresh}.__dict__)"]
        if isinstance(declaration, Union):
            return list(self._fill_union(declaration))
        lines = list(self._fill_struct(declaration, "wire", "value", False, set()))
        return lines or ["pass"]

    def to(self, declaration: Struct | Union | ExceptionDecl) -> list[str]:
        """Return the body of the function that makes a wire object from `value`."""
        if self._holds_values(declaration):
            return [f"return {self._py.octets(declaration)}.to(value)"]
        class_ = self._py.wire_class(declaration)
        if isinstance(declaration, ExceptionDecl):
            parts = (
                self._outgoing(field.type, f"value.{field.ours}")
                for field in self._fields(declaration)
            )
            return [f"return {class_}({', '.join(parts)})"]
        lines = [f"wire = {self._new(class_)}"]
        if isinstance(declaration, Union):
            fill = self._py.function("fill", declaration.name)
            return [*lines, f"{fill}(wire, value)", "return wire"]
        if declaration.annotation(OPAQUE) is not None:
            lines.append(f"wire.{STAND_IN} = 0")
        lines += self._fill_struct(declaration, "wire", "value", True, set())
        return [*lines, "return wire"]

    def of(self, declaration: Struct | Union | ExceptionDecl) -> list[str]:
        """Return the body of the function that makes a value from `wire`."""
        ours = self._py.type(declaration.name)
        if self._holds_values(declaration):
            octets = self._py.octets(declaration)
            return [f"value: {ours} = {octets}.of(wire)", "return value"]
        if isinstance(declaration, Union):
            return list(self._of_union(declaration))
        if isinstance(declaration, ExceptionDecl):
            parts = (
                self._incoming(field.type, f"wire.{field.theirs}")
                for field in self._fields(declaration)
            )
            return [f"return {ours}({', '.join(parts)})"]
        lines, made = self._made(declaration, "wire", set())
        return [*lines, f"return {made}"]

    def _holds_values(self, declaration: Struct | Union | ExceptionDecl) -> bool:
        return self._classic.holds_values(NamedType(declaration.name))

    def _fields(self, declaration: Struct | ExceptionDecl) -> list[_Field]:
        if isinstance(declaration, ExceptionDecl):
            names = self._names.python.members(declaration)
            return [
                _Field(names[m.name], mangled(m.name), m.type)
                for m in declaration.members
            ]
        found = []
        for struct, place in self._classic.members(declaration):
            member = struct.members[place]
            name = self._names.python.members(struct)[member.name]
            found.append(_Field(name, mangled(member.name), member.type))
        return found

    def _fill_struct(
        self, struct: Struct, wire: str, value: str, fresh: bool, used: set[str]
    ) -> Iterator[str]:
        for field in self._fields(struct):
            there, here = f"{wire}.{field.theirs}", f"{value}.{field.ours}"
            inner = self._inner(field.type)
            if inner is None:
                yield from self._fill_field(field.type, there, here, fresh)
                continue
            inner_wire = _variable(f"{wire}_{field.theirs}", used)
            inner_value = _variable(f"{value}_{field.ours}", used)
            made = (
                f"{there} = {self._new(self._py.wire_class(inner))}" if fresh else there
            )
            yield f"{inner_wire} = {made}"
            yield f"{inner_value} = {here}"
            yield from self._fill_struct(inner, inner_wire, inner_value, fresh, used)

    def _fill_field(
        self, type_: Type, there: str, here: str, fresh: bool
    ) -> Iterator[str]:
        plain = self._model.unalias(type_)
        struct, element = self._struct(plain), self._kept_element(plain)
        if fresh or (struct is element is None and not self._is_same(plain)):
            yield f"{there} = {self._outgoing(type_, here)}"
        elif struct is not None:
            yield f"{self._py.function('fill', struct.name)}({there}, {here})"
        elif element is not None:
            fill = self._py.function("fill", element.name)
            to = self._py.function("to", element.name)
            yield f"if {here} or {there}:"
            yield f"    {self._py.helper('refill')}({there}, {here}, {fill}, {to})"
        else:
            yield f"{there} = {self._shared(plain, here)}"

    def _shared(self, plain: Type, expression: str) -> str:
        """Return a value that omniORB marshals as is; numbers in another form as a list."""
        return self._number_list("as_list", plain, expression) or expression

    def _number_list(self, helper: str, plain: Type, expression: str) -> str:
        """Return a list of numbers made by a helper; empty for another type."""
        if not isinstance(plain, SequenceType | ArrayType):
            return ""
        element = self._model.unalias(plain.element)
        if not isinstance(element, PrimitiveType) or element.kind not in _IN_BUFFERS:
            return ""
        depth = len(plain.dimensions) if isinstance(plain, ArrayType) else 1
        further = f", {depth}" if depth > 1 else ""
        return f"{self._py.helper(helper)}({expression}{further})"

    def _kept_element(self, plain: Type) -> Struct | None:
        """Return the struct of a list's items, if their wire objects are reused."""
        match plain:
            case SequenceType(element, numeric="list") | ArrayType(element, (_,)):
                return self._struct(self._model.unalias(element))
        return None

    def _struct(self, plain: Type) -> Struct | None:
        if isinstance(plain, NamedType):
            declaration = self._model.find(plain.name)
            if isinstance(declaration, Struct):
                return declaration
        return None

    def _inner(self, type_: Type) -> Struct | None:
        """Return the struct of a member that is converted in place."""
        struct = self._struct(self._model.unalias(type_))
        if struct is None or self._holds_values(struct):
            return None
        return struct if self._size(struct) <= _INLINE else None

    def _size(self, struct: Struct) -> int:
        """Return the number of fields and inner structs, or a number above `_INLINE`."""
        if struct.name not in self._sizes:
            size = 1
            for field in self._fields(struct):
                inner = self._struct(self._model.unalias(field.type))
                size += 1 if inner is None else self._size(inner)
                if size > _INLINE:
                    break
            self._sizes[struct.name] = size
        return self._sizes[struct.name]

    def _made(self, struct: Struct, wire: str, used: set[str]) -> tuple[list[str], str]:
        """Return the statements that a value needs, and the expression that makes it."""
        lines: list[str] = []
        arguments: list[str] = []
        for field in self._fields(struct):
            there = f"{wire}.{field.theirs}"
            inner = self._inner(field.type)
            if inner is None:
                arguments.append(self._incoming(field.type, there))
                continue
            variable = _variable(f"{wire}_{field.theirs}", used)
            more, made = self._made(inner, variable, used)
            lines += [f"{variable} = {there}", *more]
            arguments.append(made)
        return lines, f"{self._py.type(struct.name)}({', '.join(arguments)})"

    def _new(self, class_: str) -> str:
        return f"{self._py.helper('new')}({class_})"

    # Unions.

    def _fill_union(self, union: Union) -> Iterator[str]:
        switch = self._outgoing(union.switch, "value.discriminator")
        yield "state = wire.__dict__"
        yield f'state["_d"] = {switch}'
        any_type = self._py.helper("Any", "typing")
        if all(self._is_immutable(self._model.unalias(c.type)) for c in union.cases):
            yield 'state["_v"] = value.value'
            return
        yield f"part: {any_type} = value.value"
        yield "match value.discriminator:"
        yield from self._branches(union, self._outgoing)
        yield 'state["_v"] = part'

    def _of_union(self, union: Union) -> Iterator[str]:
        ours = self._py.type(union.name)
        switch = self._incoming(union.switch, "wire._d")
        if all(self._is_immutable(self._model.unalias(c.type)) for c in union.cases):
            yield f"return {ours}({switch}, wire._v)"
            return
        yield f"made = {switch}"
        yield f"part: {self._py.helper('Any', 'typing')} = wire._v"
        yield "match made:"
        yield from self._branches(union, self._incoming)
        yield f"return {ours}(made, part)"

    def _branches(self, union: Union, convert: _Convert) -> Iterator[str]:
        """Yield the match arms of all branches; a discriminator without one has no value."""
        default: Case | None = None
        for case in union.cases:
            if case.default:
                default = case
                continue
            labels = " | ".join(self._label(union, label) for label in case.labels)
            yield f"    case {labels}:"
            yield f"        {self._arm(case, convert)}"
        if default is not None and not self.is_same(default.type):
            yield "    case _:"
            yield f"        {self._arm(default, convert)}"

    def _arm(self, case: Case, convert: _Convert) -> str:
        made = convert(case.type, "part")
        return "pass" if made == "part" else f"part = {made}"

    def _label(self, union: Union, label: ConstantValue) -> str:
        switch = self._model.unalias(union.switch)
        if isinstance(label, EnumeratorName) and isinstance(switch, NamedType):
            _, member = self._names.python.enumerator(label.name)
            return f"{self._py.type(switch.name)}.{member}"
        if isinstance(label, bool):
            return str(label)
        return (
            string_literal(label) if isinstance(label, str) else number_literal(label)  # type: ignore[arg-type]
        )

    # Expressions.

    def outgoing(self, type_: Type, expression: str) -> str:
        """Return an expression for the wire form of an argument or result; objects as
        references.
        """
        interface = self._interface(type_)
        if interface is None:
            return self._outgoing(type_, expression)
        return f"{self._py.function('objects', interface.name)}.to({expression})"

    def incoming(self, type_: Type, expression: str) -> str:
        """Return an expression for the value of an argument or result; objects are stubs."""
        interface = self._interface(type_)
        if interface is None:
            return self._incoming(type_, expression)
        return f"{self._py.function('objects', interface.name)}.of({expression})"

    def is_same(self, type_: Type) -> bool:
        """Return whether an argument or result is the same object on both sides."""
        return self._is_immutable(self._model.unalias(type_))

    def _interface(self, type_: Type) -> Interface | None:
        plain = self._model.unalias(type_)
        if isinstance(plain, NamedType):
            declaration = self._model.find(plain.name)
            if isinstance(declaration, Interface):
                return declaration
        return None

    def _outgoing(self, type_: Type, expression: str, depth: int = 1) -> str:
        """Return an expression for a wire form that shares no data with the value."""
        plain = self._model.unalias(type_)
        if self._is_immutable(plain):
            return expression
        if self._is_octets(plain):
            return f"{self._py.helper('octets')}({expression})"
        match plain:
            case FixedType(digits, scale):
                to_fixed = self._py.helper("to_fixed")
                return f"{to_fixed}({expression}, {digits}, {scale})"
            case SequenceType() | ArrayType():
                return self._items(plain, expression, depth, self._outgoing)
            case NamedType(name):
                declaration = self._model.find(name)
                match declaration:
                    case Enum():
                        return f"{self._py.items(declaration)}[{expression}]"
                    case Struct() | Union():
                        return f"{self._py.function('to', name)}({expression})"
        return f"{self._octets(plain)}.to({expression})"

    def _incoming(self, type_: Type, expression: str, depth: int = 1) -> str:
        """Return an expression for a value that shares no data with the wire form."""
        plain = self._model.unalias(type_)
        if self._is_immutable(plain) or self._is_octets(plain):
            return expression
        match plain:
            case FixedType():
                return f"{self._py.helper('from_fixed')}({expression})"
            case SequenceType() | ArrayType():
                return self._items(plain, expression, depth, self._incoming)
            case NamedType(name):
                declaration = self._model.find(name)
                match declaration:
                    case Enum():
                        return f"{self._py.members(declaration)}[{expression}._v]"
                    case Struct() | Union():
                        return f"{self._py.function('of', name)}({expression})"
        return f"{self._octets(plain)}.of({expression})"

    def _items(
        self,
        type_: SequenceType | ArrayType,
        expression: str,
        depth: int,
        convert: _Convert,
    ) -> str:
        if type_.numeric != "list":
            return self._numbers(type_, expression, depth, convert)
        element = _element(type_)
        if self._names.mapping.is_text(type_):
            if convert == self._outgoing:
                return f"list({expression})"
            octets = self._names.mapping.annotation(type_) == "bytes"
            return f"bytes({expression})" if octets else f'"".join({expression})'
        numbers = self._number_list("listed", type_, expression)
        if numbers and convert == self._outgoing:
            return numbers
        item = "item" if depth == 1 else f"item_{depth}"
        made = convert(element, item, depth + 1)
        if made == item:
            return f"list({expression})"
        return f"[{made} for {item} in {expression}]"

    def _numbers(
        self,
        type_: SequenceType | ArrayType,
        expression: str,
        depth: int,
        convert: _Convert,
    ) -> str:
        """Return an expression for numbers in another form than a list, which omniORB uses."""
        element = self._model.unalias(type_.element)
        outgoing = convert == self._outgoing
        if isinstance(element, PrimitiveType):
            if outgoing:
                return f"{self._py.helper('listed')}({expression})"
            code = string_literal(NUMBERS[element.kind].code)
            return f"{self._py.helper(f'to_{type_.numeric}')}({expression}, {code})"
        assert isinstance(element, NamedType)
        struct = self._py.type(element.name)
        listed = replace(type_, numeric="list")
        if outgoing:
            structs = f"{self._py.helper('structs_of')}({expression}, {struct})"
            return self._items(listed, structs, depth, convert)
        items = self._items(listed, expression, depth, convert)
        return f"{self._py.helper('to_records')}({items}, {struct})"

    def _octets(self, plain: Type) -> str:
        if isinstance(plain, PrimitiveType):
            return self._py.helper(_BY_OCTETS[plain.kind])
        assert isinstance(plain, NamedType)
        declaration = self._model.find(plain.name)
        assert isinstance(declaration, Interface | Valuetype | ValueBox)
        return self._py.octets(declaration)

    def _is_immutable(self, plain: Type) -> bool:
        """Return whether both sides have the same immutable values."""
        match plain:
            case PrimitiveType(kind):
                return kind not in _BY_OCTETS
            case FixedType():
                return False
            case SequenceType() | ArrayType():
                # omniORBpy uses lists where the definition has an alias of octet or char.
                return self._is_direct_text(plain) and not self._is_octets(plain)
            case NamedType():
                return False
        return True

    def _is_direct_text(self, plain: SequenceType | ArrayType) -> bool:
        direct = isinstance(_element(plain), PrimitiveType)
        return direct and self._names.mapping.is_text(plain)

    def _is_octets(self, plain: Type) -> bool:
        """Return whether a value is `bytes` in omniORBpy, and any buffer of octets in rtgen."""
        if not isinstance(plain, SequenceType | ArrayType):
            return False
        octets = self._names.mapping.annotation(plain) == "bytes"
        return octets and self._is_direct_text(plain)

    def _is_same(self, plain: Type) -> bool:
        """Return whether omniORB marshals the value as is: immutable values and lists of them."""
        if self._is_immutable(plain):
            return True
        if isinstance(plain, SequenceType | ArrayType):
            if plain.numeric != "list":
                return False
            texts = self._names.mapping.is_text(plain)
            return not texts and self._is_same(self._model.unalias(_element(plain)))
        return False


def _element(type_: SequenceType | ArrayType) -> Type:
    """Return the type of a list's items; those of an array of arrays are arrays."""
    if isinstance(type_, ArrayType) and len(type_.dimensions) > 1:
        return ArrayType(type_.element, type_.dimensions[1:])
    return type_.element


def _variable(name: str, used: set[str]) -> str:
    while name in used:
        name += "_"
    used.add(name)
    return name
