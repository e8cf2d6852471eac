"""Expressions of descriptors, which describe types at run time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import msgspec

from rtgen.compiler.backends.kit.python_initial import PythonInitial
from rtgen.compiler.backends.kit.python_text import (
    Bracketed,
    fit_bracketed,
    tuple_of,
)
from rtgen.compiler.backends.kit.quoting.python import string_literal
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.layouts.cdr_types import CdrTypes, bit_count
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    ArrayType,
    Attribute,
    Bitmask,
    Bitset,
    Case,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Extensibility,
    FixedType,
    InitialValue,
    Interface,
    MapType,
    Member,
    Model,
    NamedType,
    Operation,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StateMember,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
    default_id,
)
from rtgen.compiler.model.declarations import OPAQUE, ConstantValue, Declaration
from rtgen.compiler.typemap.python.idl import is_boolean, is_signed
from rtgen.compiler.typemap.python.idl_names import PythonNames, is_emitted


class Descriptions(msgspec.Struct, eq=False):
    """Writes descriptors into one module."""

    _model: Model
    _names: PythonNames
    _types: CdrTypes
    _py: Scope
    _is_ahead: Callable[[Type], bool]
    _representations: Representations
    _literals: PythonInitial

    def of(self, type_: Type) -> str:
        """Return the descriptor of a type in a member, element or alias."""
        idl = self._py.idl
        match type_:
            case PrimitiveType(kind):
                return f"{idl}.{kind.name}"
            case StringType(wide, None):
                return f"{idl}.{'WSTRING' if wide else 'STRING'}"
            case StringType(wide, bound):
                return f"{idl}.{'wstring' if wide else 'string'}({bound})"
            case FixedType(digits, scale):
                return f"{idl}.fixed({digits}, {scale})"
            case SequenceType(element, bound):
                bounded = "" if bound is None else f", {bound}"
                bounded += _form(type_)
                return f"{idl}.sequence({self.of(element)}{bounded})"
            case ArrayType(element, dimensions):
                sizes = ", ".join(map(str, dimensions))
                sizes += _form(type_)
                return f"{idl}.array({self.of(element)}, {sizes})"
            case MapType(key, value, bound):
                bounded = "" if bound is None else f", {bound}"
                return f"{idl}.map_({self.of(key)}, {self.of(value)}{bounded})"
            case NamedType(name):
                return self._named(type_, name)

    def _named(self, type_: Type, name: ScopedName) -> str:
        py = self._py
        declaration = self._model.find(name)
        if isinstance(declaration, Typedef):
            return py.alias(name)
        if not is_emitted(declaration):
            scoped = string_literal(declaration.scoped)
            return f"{py.PrimitiveDescriptor}({scoped})"
        if isinstance(declaration, Interface):
            # An object reference: its operations are not part of the data.
            facts = [self._head(declaration), *_interface_kind(declaration)]
            return f"{py.InterfaceDescriptor}({', '.join(facts)})"
        declared = py.reference(name)
        if not (self._types.is_recursive(name) or self._is_ahead(type_)):
            return declared
        linked = [string_literal(declaration.scoped), f"lambda: {declared}"]
        return f"{py.idl}.link({', '.join([*linked, *self._own_id(declaration)])})"

    def struct(self, declaration: Struct | ExceptionDecl, representation: int) -> str:
        """Return the descriptor of a struct or exception, split like that of a class variable."""
        py = self._py
        kind = "struct" if isinstance(declaration, Struct) else "exception"
        names = self._names.members(declaration)
        traits = self._traits(declaration, representation)
        facts = [
            string_literal(declaration.scoped),
            *self._marks([*self._own_id(declaration), *traits]),
            *(self._member(m, names[m.name]) for m in declaration.members),
        ]
        variable = f"_descriptor_{py.class_variable} = "
        text = fit_bracketed(Bracketed(f"{variable}{py.idl}.{kind}(", facts), 4)
        return text.removeprefix(f"    {variable}")

    def _member(self, member: Member, attribute: str) -> str:
        """Return a member as an argument."""
        more = _differing(member, attribute)
        if member.optional or member.key or member.must_understand or member.external:
            for flag in ("optional", "key", "must_understand", "external"):
                more += [f"{flag}=True"] * getattr(member, flag)
        if isinstance(member, StateMember) and not member.public:
            more.append("private=True")
        type_ = self.of(member.type)
        if more:
            type_ = f"{self._py.idl}.member({', '.join([type_, *more])})"
        return f"{attribute}={type_}"

    def value(self, declaration: Valuetype) -> str:
        """Return the descriptor of a valuetype."""
        names = self._names.members(declaration)
        state = [self._member(m, names[m.name]) for m in declaration.state]
        bases = [self._py.reference(b) for b in declaration.bases]
        kinds = ("custom", "abstract", "truncatable")
        modifier = next((kind for kind in kinds if getattr(declaration, kind)), "")
        own_id = self._positional_id(declaration)
        facts: list[str] = [string_literal(declaration.scoped)]
        if modifier or bases or own_id:
            facts.append(f'"{modifier}"')
        if bases or own_id:
            facts.append(tuple_of(bases).flat)
        return f"{self._py.idl}.value({', '.join([*facts, *own_id, *state])})"

    def box(self, declaration: ValueBox) -> str:
        """Return the descriptor of a boxed value."""
        facts = [string_literal(declaration.scoped), self.of(declaration.type)]
        facts += self._own_id(declaration)
        return f"{self._py.idl}.box({', '.join(facts)})"

    def alias(self, declaration: Typedef, representation: int) -> str:
        """Return the descriptor of a typedef."""
        facts = [string_literal(declaration.scoped), self.of(declaration.type)]
        facts += self._own_id(declaration)
        facts += [f"representation={representation}"] * bool(representation)
        facts += self._initial(declaration.type, declaration.initial)
        return f"{self._py.idl}.alias({', '.join(facts)})"

    def enum(self, declaration: Enum | Bitmask, class_: str) -> str:
        """Return the statement that describes an enum or a bitmask."""
        kind = "enum" if isinstance(declaration, Enum) else "flags"
        names = self._names.enumerators(declaration)
        facts = [class_, string_literal(declaration.scoped)]
        lacking = [f'"{names[n]}": "{n}"' for n in names if names[n] != n]
        facts += [f"names={{{', '.join(lacking)}}}"] * bool(lacking)
        facts += [f"bound={declaration.bound}"] * (declaration.bound != 32)
        facts += self._own_id(declaration)
        if isinstance(declaration, Enum) and (
            declaration.initial is not declaration.members[0]
        ):
            facts.append(f"initial={class_}.{names[declaration.initial.name]}")
        return f"{self._py.idl}.{kind}({', '.join(facts)})"

    def _initial(self, type_: Type, value: InitialValue | None) -> list[str]:
        """Return a default as an argument: a scalar, or the tuple of a list's items."""
        if value is None:
            return []
        plain = self._model.unalias(type_)
        if not isinstance(value, tuple):
            return [f"initial={self._literals.explicit(plain, value)}"]
        assert isinstance(plain, SequenceType | ArrayType)
        element = self._model.unalias(plain.element)
        items = [self._literals.explicit(element, item) for item in value]
        return [f"initial={tuple_of(items).flat}"]

    def bitset(self, declaration: Bitset) -> str:
        """Return the descriptor of a bitset."""
        facts = [
            string_literal(declaration.scoped),
            str(bit_count(self._model, declaration)),
        ]
        facts += [*self._positional_id(declaration), *self._bitfields(declaration)]
        return f"{self._py.idl}.bitset({', '.join(facts)})"

    def _bitfields(self, declaration: Bitset) -> list[str]:
        """Return the descriptors of the named fields, inherited ones first."""
        described: list[str] = []
        position = 0
        for each in self._model.lineage(declaration):
            names = self._names.members(each)
            for field in each.members:
                if field.name is not None:
                    facts = [str(field.bits), str(position)]
                    facts += ["signed=True"] * is_signed(self._model, field)
                    facts += ["boolean=True"] * is_boolean(self._model, field)
                    attribute = names[field.name]
                    facts += [f'name="{field.name}"'] * (attribute != field.name)
                    text = f"{self._py.idl}.bits({', '.join(facts)})"
                    described.append(f"{attribute}={text}")
                position += field.bits
        return described

    def union(self, declaration: Union, representation: int) -> str:
        """Return the descriptor of a union."""
        idl = self._py.idl
        names = self._names.members(declaration)
        facts = [string_literal(declaration.scoped), self.of(declaration.switch)]
        traits = self._traits(declaration, representation)
        facts += self._marks([*self._own_id(declaration), *traits])
        for case in declaration.cases:
            attribute = names[case.name]
            parts = [self.of(case.type)]
            parts += map(self.label, case.labels)
            parts += ["default=True"] * case.default
            parts += _differing(case, attribute)
            parts += ["external=True"] * case.external
            parts += self._initial(case.type, case.initial)
            facts.append(f"{attribute}={idl}.case({', '.join(parts)})")
        return f"{idl}.union({', '.join(facts)})"

    def label(self, value: ConstantValue) -> str:
        """Return the expression for a label."""
        if isinstance(value, EnumeratorName):
            enum, member = self._names.enumerator(value.name)
            return f"{self._py.reference(enum)}.{member}"
        return string_literal(value) if isinstance(value, str) else str(value)

    def interface(self, declaration: Interface) -> str:
        """Return the class variable with the descriptor of an interface, as lines."""
        py = self._py
        texts = [attribute_text(attribute) for attribute in declaration.attributes]
        texts += [signature(operation) for operation in declaration.operations]
        bases = [f"{py.reference(b)}._descriptor_" for b in declaration.bases]
        facts: list[str | Bracketed] = [
            string_literal(declaration.repository_id),
            string_literal(declaration.scoped),
            tuple_of([string_literal(text) for text in texts]),
            tuple_of(bases),
            *_interface_kind(declaration),
        ]
        facts += ["opaque=True"] * (declaration.annotation(OPAQUE) is not None)
        kind = py.InterfaceDescriptor
        head = f"_descriptor_: {py.ClassVar}[{kind}] = {kind}("
        return fit_bracketed(Bracketed(head, facts), 4)

    def _traits(
        self, declaration: Struct | Union | ExceptionDecl, representation: int
    ) -> list[str]:
        """Return the properties that differ from their defaults, without the repository id."""
        facts: list[str] = []
        if not isinstance(declaration, ExceptionDecl):
            if isinstance(declaration, Struct) and declaration.base is not None:
                facts.append(f"base={self._py.reference(declaration.base)}")
            extensibility = self._representations.extensibility(declaration)
            if extensibility is not Extensibility.FINAL:
                facts.append(f'extensibility="{extensibility}"')
            facts += ["nested=True"] * declaration.nested
            facts += ["opaque=True"] * (declaration.annotation(OPAQUE) is not None)
        facts += [f"representation={representation}"] * bool(representation)
        return facts

    def _marks(self, facts: Sequence[str]) -> list[str]:
        """Return properties as at most one argument."""
        return [f"{self._py.idl}.traits({', '.join(facts)})"] if facts else []

    def _own_id(self, declaration: Declaration) -> list[str]:
        """Return the repository id, if it differs from the one derived from the name."""
        return [f"repository_id={text}" for text in self._positional_id(declaration)]

    def _positional_id(self, declaration: Declaration) -> list[str]:
        own = declaration.repository_id
        return [] if own == default_id(declaration.name) else [string_literal(own)]

    def _head(self, declaration: Declaration) -> str:
        return f"{string_literal(declaration.repository_id)}, {string_literal(declaration.scoped)}"


def _form(type_: SequenceType | ArrayType) -> str:
    return "" if type_.numeric == "list" else f', numeric="{type_.numeric}"'


def attribute_text(attribute: Attribute) -> str:
    """Return an attribute in IDL syntax, on one line."""
    if attribute.readonly:
        raises = _raises("raises", attribute.get_raises)
        return f"readonly attribute {attribute.type} {attribute.name}{raises}"
    raises = _raises("getraises", attribute.get_raises)
    raises += _raises("setraises", attribute.set_raises)
    return f"attribute {attribute.type} {attribute.name}{raises}"


def signature(operation: Operation) -> str:
    """Return an operation in IDL syntax, on one line."""
    parameters = [
        f"{p.direction} {_spelled(p.type)} {p.name}" for p in operation.parameters
    ]
    text = f"{_spelled(operation.returns)} {operation.name}({', '.join(parameters)})"
    text += _raises("raises", operation.raises)
    if operation.context:
        text += f" context ({', '.join(map(string_literal, operation.context))})"
    return f"oneway {text}" if operation.oneway else text


@lru_cache(maxsize=4096)
def _spelled(type_: Type) -> str:
    return str(type_)


def _raises(word: str, names: Sequence[ScopedName]) -> str:
    if not names:
        return ""
    listed = ", ".join(["::".join(name) for name in dict.fromkeys(names)])
    return f" {word} ({listed})"


def _interface_kind(declaration: Interface) -> list[str]:
    return ["abstract=True"] * declaration.abstract + ["local=True"] * declaration.local


def _differing(entry: Member | Case, attribute: str) -> list[str]:
    """Return the Python name and the member id, if they differ from their defaults."""
    facts = [] if attribute == entry.name else [f'name="{entry.name}"']
    return facts if entry.id is None else [*facts, f"member_id={entry.id}"]
