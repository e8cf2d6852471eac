"""The expressions of descriptors, which say at run time what a type is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rtgen.backends.quoting.python import string_literal
from rtgen.backends.types.scope import Scope
from rtgen.layouts.cdr_types import CdrTypes, bit_count
from rtgen.layouts.representations import Representations
from rtgen.model import (
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
)
from rtgen.model.declarations import OPAQUE, ConstantValue, Declaration
from rtgen.typemap.idl_python import PythonNames, is_boolean, is_emitted, is_signed


class Descriptions:
    """Writes descriptors into one module."""

    def __init__(
        self,
        model: Model,
        names: PythonNames,
        types: CdrTypes,
        scope: Scope,
        is_ahead: Callable[[Type], bool],
        representations: Representations,
    ) -> None:
        self._representations = representations
        self._is_ahead = is_ahead
        self._model = model
        self._names = names
        self._types = types
        self._py = scope

    def of(self, type_: Type) -> str:
        """The descriptor of a type where it is used."""
        py = self._py
        match type_:
            case PrimitiveType(kind):
                return f'{py.PrimitiveDescriptor}("{kind}")'
            case StringType(wide, bound):
                wide_text = ["True"] if wide else []
                bound_text = [] if bound is None else [f"bound={bound}"]
                return f"{py.StringDescriptor}({', '.join(wide_text + bound_text)})"
            case FixedType(digits, scale):
                return f"{py.FixedDescriptor}({digits}, {scale})"
            case SequenceType(element, bound):
                bounded = "" if bound is None else f", {bound}"
                return f"{py.SequenceDescriptor}({self.of(element)}{bounded})"
            case ArrayType(element, dimensions):
                return f"{py.ArrayDescriptor}({self.of(element)}, {dimensions})"
            case MapType(key, value, bound):
                bounded = "" if bound is None else f", {bound}"
                return f"{py.MapDescriptor}({self.of(key)}, {self.of(value)}{bounded})"
            case NamedType(name):
                declaration = self._model.find(name)
                if isinstance(declaration, Typedef):
                    return py.alias(name)
                if not is_emitted(declaration):
                    return f"{py.PrimitiveDescriptor}({string_literal(declaration.scoped)})"
                if isinstance(declaration, Interface):
                    # A reference to an object: the operations are not part of the data.
                    facts = [self._head(declaration), *_interface_kind(declaration)]
                    return f"{py.InterfaceDescriptor}({', '.join(facts)})"
                declared = py.reference(name)
                if not (self._types.is_recursive(name) or self._is_ahead(type_)):
                    return f"{declared}._descriptor_"
                head = self._head(declaration)
                return f"{py.LinkDescriptor}({head}, lambda: {declared}._descriptor_)"

    def struct(self, declaration: Struct | ExceptionDecl) -> str:
        """The descriptor of a struct or exception."""
        py = self._py
        is_struct = isinstance(declaration, Struct)
        kind = py.StructDescriptor if is_struct else py.ExceptionDescriptor
        members = _tuple(self._members(declaration))
        more = self._traits(declaration)
        return f"{kind}({self._head(declaration)}, {members}{more})"

    def _members(self, declaration: Struct | ExceptionDecl) -> list[str]:
        """The descriptors of the members, inherited ones first."""
        inherited: list[str] = []
        if isinstance(declaration, Struct) and declaration.base is not None:
            base = self._model.find(declaration.base)
            assert isinstance(base, Struct)
            inherited = self._members(base)
        names = self._names.members(declaration)
        return inherited + [self._member(m, names[m.name]) for m in declaration.members]

    def _member(self, member: Member, attribute: str) -> str:
        facts = [f'"{member.name}"', self.of(member.type)]
        facts += _differing(member, attribute)
        for flag in ("optional", "key", "must_understand", "external"):
            facts += [f"{flag}=True"] * getattr(member, flag)
        if isinstance(member, StateMember) and not member.public:
            facts.append("private=True")
        return f"{self._py.MemberDescriptor}({', '.join(facts)})"

    def value(self, declaration: Valuetype) -> str:
        """The descriptor of a valuetype."""
        names = self._names.members(declaration)
        state = [self._member(m, names[m.name]) for m in declaration.state]
        bases = [f"{self._py.reference(b)}._descriptor_" for b in declaration.bases]
        facts = [self._head(declaration), _tuple(state)]
        kinds = ("custom", "abstract", "truncatable")
        modifier = next((kind for kind in kinds if getattr(declaration, kind)), "")
        if bases or modifier:
            facts.append(_tuple(bases))
        facts += [f'"{modifier}"'] * bool(modifier)
        return f"{self._py.ValueDescriptor}({', '.join(facts)})"

    def box(self, declaration: ValueBox) -> str:
        """The descriptor of a boxed value."""
        target = self.of(declaration.type)
        return f"{self._py.BoxDescriptor}({self._head(declaration)}, {target})"

    def alias(self, declaration: Typedef) -> str:
        """The descriptor of a typedef."""
        target = self.of(declaration.type)
        return f"{self._py.AliasDescriptor}({self._head(declaration)}, {target})"

    def enum(self, declaration: Enum) -> str:
        """The descriptor of an enum."""
        pairs = [f'("{m.name}", {m.value})' for m in declaration.members]
        facts = [self._head(declaration), _tuple(pairs)]
        facts += [] if declaration.bound == 32 else [str(declaration.bound)]
        return f"{self._py.EnumDescriptor}({', '.join(facts)})"

    def flags(self, declaration: Bitmask) -> str:
        """The descriptor of a bitmask."""
        pairs = [f'("{m.name}", {m.value})' for m in declaration.members]
        head = self._head(declaration)
        return (
            f"{self._py.FlagsDescriptor}({head}, {_tuple(pairs)}, {declaration.bound})"
        )

    def bitset(self, declaration: Bitset) -> str:
        """The descriptor of a bitset."""
        count = bit_count(self._model, declaration)
        fields = _tuple(self._bitfields(declaration))
        return (
            f"{self._py.BitsetDescriptor}({self._head(declaration)}, {fields}, {count})"
        )

    def _bitfields(self, declaration: Bitset) -> list[str]:
        """The descriptors of the named fields, inherited ones first."""
        described: list[str] = []
        position = 0
        if declaration.base is not None:
            base = self._model.find(declaration.base)
            assert isinstance(base, Bitset)
            described = self._bitfields(base)
            position = bit_count(self._model, base)
        names = self._names.members(declaration)
        for field in declaration.members:
            if field.name is not None:
                facts = [f'"{field.name}"', str(field.bits), str(position)]
                facts += ["signed=True"] * is_signed(self._model, field)
                facts += ["boolean=True"] * is_boolean(self._model, field)
                if names[field.name] != field.name:
                    facts.append(f'attribute="{names[field.name]}"')
                described.append(f"{self._py.BitfieldDescriptor}({', '.join(facts)})")
            position += field.bits
        return described

    def union(self, declaration: Union) -> str:
        """The descriptor of a union."""
        py = self._py
        names = self._names.members(declaration)
        branches = []
        for case in declaration.cases:
            labels = [self.label(declaration, label) for label in case.labels]
            facts = [_tuple(labels), str(case.default), f'"{case.name}"']
            facts += [self.of(case.type), *_differing(case, names[case.name])]
            facts += ["external=True"] * case.external
            branches.append(f"{py.BranchDescriptor}({', '.join(facts)})")
        switch = self.of(declaration.switch)
        head = self._head(declaration)
        more = self._traits(declaration)
        return f"{py.UnionDescriptor}({head}, {switch}, {_tuple(branches)}{more})"

    def label(self, declaration: Union, value: ConstantValue) -> str:
        """The expression for a label."""
        if isinstance(value, EnumeratorName):
            enum, member = self._names.enumerator(value.name)
            return f"{self._py.reference(enum)}.{member}"
        return string_literal(value) if isinstance(value, str) else str(value)

    def interface(self, declaration: Interface) -> str:
        """The descriptor of an interface."""
        texts = [attribute_text(attribute) for attribute in declaration.attributes]
        texts += [signature(operation) for operation in declaration.operations]
        bases = [f"{self._py.reference(b)}._descriptor_" for b in declaration.bases]
        operations = _tuple([string_literal(text) for text in texts])
        head = self._head(declaration)
        facts = [head, operations, _tuple(bases), *_interface_kind(declaration)]
        facts += ["opaque=True"] * (declaration.annotation(OPAQUE) is not None)
        return f"{self._py.InterfaceDescriptor}({', '.join(facts)})"

    def _traits(self, declaration: Struct | Union | ExceptionDecl) -> str:
        """Extensibility and `nested`, where they are not the usual ones."""
        text = ""
        if isinstance(declaration, ExceptionDecl):
            return text
        extensibility = self._representations.extensibility(declaration)
        if extensibility is not Extensibility.FINAL:
            text = f', extensibility="{extensibility}"'
        text = f"{text}, nested=True" if declaration.nested else text
        return f"{text}, opaque=True" if declaration.annotation(OPAQUE) else text

    def _head(self, declaration: Declaration) -> str:
        return f"{string_literal(declaration.repository_id)}, {string_literal(declaration.scoped)}"


def attribute_text(attribute: Attribute) -> str:
    """An attribute as IDL writes it, on one line."""
    if attribute.readonly:
        raises = _raises("raises", attribute.get_raises)
        return f"readonly attribute {attribute.type} {attribute.name}{raises}"
    raises = _raises("getraises", attribute.get_raises)
    raises += _raises("setraises", attribute.set_raises)
    return f"attribute {attribute.type} {attribute.name}{raises}"


def signature(operation: Operation) -> str:
    """An operation as IDL writes it, on one line."""
    parameters = [f"{p.direction} {p.type} {p.name}" for p in operation.parameters]
    text = f"{operation.returns} {operation.name}({', '.join(parameters)})"
    text += _raises("raises", operation.raises)
    if operation.context:
        text += f" context ({', '.join(map(string_literal, operation.context))})"
    return f"oneway {text}" if operation.oneway else text


def _raises(word: str, names: Sequence[ScopedName]) -> str:
    listed = ", ".join("::".join(name) for name in dict.fromkeys(names))
    return f" {word} ({listed})" if listed else ""


def _interface_kind(declaration: Interface) -> list[str]:
    return ["abstract=True"] * declaration.abstract + ["local=True"] * declaration.local


def _differing(entry: Member | Case, attribute: str) -> list[str]:
    """The Python name and the member id, where they are not what one would expect."""
    facts = [] if attribute == entry.name else [f'attribute="{attribute}"']
    return facts if entry.id is None else [*facts, f"id={entry.id}"]


def _tuple(items: list[str]) -> str:
    return f"({items[0]},)" if len(items) == 1 else f"({', '.join(items)})"
