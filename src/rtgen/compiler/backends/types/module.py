"""The text of one implementation module: all declarations of an IDL file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import Decimal
from math import isfinite

import msgspec

from rtgen.compiler.backends.kit.member_texts import member_text
from rtgen.compiler.backends.kit.python_initial import PythonInitial
from rtgen.compiler.backends.kit.quoting.python import (
    docstring,
    number_literal,
    string_literal,
)
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.types.calls import Calls, CallTable
from rtgen.compiler.backends.types.descriptions import Descriptions
from rtgen.compiler.backends.types.interfaces import Interfaces
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.backends.types.unions import Unions
from rtgen.compiler.backends.types.valuetypes import Statement, Valuetypes
from rtgen.compiler.layouts.cdr_types import CdrTypes, NotMarshalledError
from rtgen.compiler.layouts.representations import Representations
from rtgen.compiler.model import (
    ArrayType,
    Bitmask,
    Bitset,
    Case,
    Const,
    ConstantValue,
    Declaration,
    Enum,
    EnumeratorName,
    ExceptionDecl,
    Interface,
    MapType,
    Member,
    NamedType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.compiler.model.initial import selected
from rtgen.compiler.typemap.python.idl import PythonMapping, is_boolean
from rtgen.compiler.typemap.python.idl_names import PythonNames, is_emitted


class Block(msgspec.Struct, frozen=True):
    """A top-level part of a module; adjacent small ones have fewer blank lines between."""

    text: str
    small: bool = False


_HIDING = (
    "# pyright: reportAssignmentType=false, reportIncompatibleVariableOverride=false"
)
"""For a module in which a type nested in an interface hides one of a base."""


class TypesModule:
    """Builds one module."""

    def __init__(
        self,
        calls: Calls,
        names: PythonNames,
        types: CdrTypes,
        representations: Representations,
        module: str,
    ) -> None:
        self._representations = representations
        model = calls.model
        self._model = model
        self._calls = calls
        self._names = names
        self._types = types
        self._module = module
        self._home = names.home(module)
        self.scope = Scope(names, module)
        self._done: set[str] = set()
        self._waiting: list[Typedef] = []
        self.codecs: set[ScopedName] = set()
        self._late: dict[ScopedName, str] = {}
        self._mapping = PythonMapping(model, self.scope.reference, self.scope.spell)
        initial = PythonInitial(self._mapping)
        self._describe = Descriptions(
            model, names, types, self.scope, self._is_ahead, representations, initial
        )
        self._unions = Unions(names, model, types, self.scope, self._describe)
        self._interfaces = Interfaces(calls, names, self.scope, self._describe)
        self._valuetypes = Valuetypes(
            names,
            self.scope,
            self._mapping,
            self._describe,
            self._interfaces,
            initial,
        )

    def body(self, interfaces: Sequence[Interface] = ()) -> str:
        """Return the statements below the imports; they end with the calls of the interfaces."""
        blocks: list[Block] = []
        for declaration in self._names.declarations(self._module):
            blocks.extend(self._blocks(declaration))
            self._done.add(self._local(declaration))
            blocks.extend(self._ready_codecs())
        if interfaces:
            table = CallTable(self._calls, self.scope, self._describe, self._types)
            blocks.append(Block(table.text(interfaces)))
        parts: list[str] = []
        for before, block in zip([None, *blocks], blocks, strict=False):
            if before is not None:
                parts.append("\n" if before.small and block.small else "\n\n\n")
            parts.append(block.text.strip("\n"))
        return "".join(parts)

    @property
    def pragmas(self) -> list[str]:
        """Comments for tools below the header."""
        hiding = any(
            isinstance(declaration, Interface) and self._names.hides(declaration)
            for declaration in self._names.declarations(self._module)
        )
        return [_HIDING] if hiding else []

    def _blocks(self, declaration: Declaration) -> Iterable[Block]:
        match declaration:
            case Struct() | ExceptionDecl():
                yield Block(self._struct(declaration))
            case Union():
                yield Block(self._union(declaration))
            case Enum() | Bitmask():
                yield Block(self._enum(declaration))
            case Bitset():
                yield Block(self._bitset(declaration))
            case Const():
                yield Block(self._const(declaration), small=True)
            case Typedef():
                yield Block(self._alias(declaration), small=True)
                self._waiting.append(declaration)
            case Interface():
                nested = self._nested(declaration)
                contested = self._contested(declaration)
                yield Block(self._interfaces.text(declaration, nested, contested))
            case Valuetype():
                nested = self._nested(declaration)
                yield Block(self._valuetypes.text(declaration, nested))
            case ValueBox():
                yield Block(self._valuetypes.box(declaration))

    def _local(self, declaration: Declaration) -> str:
        return self._names.implementation(declaration.name)[1]

    def _doc(self, declaration: Declaration) -> str:
        return docstring(declaration.doc, 4, f"`{declaration.scoped}`.")

    # Structs and exceptions.

    def _struct(self, declaration: Struct | ExceptionDecl) -> str:
        is_exception = isinstance(declaration, ExceptionDecl)
        names = self._names.members(declaration)
        return render(
            "types/struct.py.j2",
            py=self.scope,
            decorator=is_exception and f"{self.scope.dataclass}(eq=False)",
            name=self._local(declaration),
            bases=self._bases(declaration),
            docstring=self._doc(declaration),
            descriptor=self._describe.struct(declaration, self._version(declaration)),
            nested=self._nested(declaration),
            fields=[
                Statement(
                    f"{names[m.name]}: {self._field(declaration, m)}",
                    docstring(member_text(m), 4),
                )
                for m in declaration.members
            ],
        )

    def _version(self, declaration: Struct | ExceptionDecl | Union) -> int:
        """The version of XCDR that `to_cdr` returns; 0 for classic CDR."""
        if isinstance(declaration, ExceptionDecl):
            headed = self._types.has_headers
            return int(any(m.optional or headed(m.type) for m in declaration.members))
        if self._representations.is_xcdr2(declaration):
            return 2
        return int(self._types.has_headers(NamedType(declaration.name)))

    def _bases(self, declaration: Struct | ExceptionDecl) -> str:
        if isinstance(declaration, ExceptionDecl):
            return self.scope.UserException
        base = self.scope.Aggregated
        if declaration.base is not None:
            base = self.scope.reference(declaration.base)
        return f"{base}{self._options(declaration)}"

    def _options(self, declaration: Struct | Union) -> str:
        """Class options; the garbage collector tracks values that can be part of a cycle."""
        name = declaration.name
        tracked = self._types.is_recursive(name) or self._types.holds_dynamic(name)
        return ", gc=True" if tracked else ""

    def _field(self, holder: Struct | ExceptionDecl, member: Member) -> str:
        if member.optional or self._types.is_unset(holder, member):
            annotation = self._mapping.annotation(member.type)
            return annotation.removesuffix(" | None") + " | None = None"
        dataclass = isinstance(holder, ExceptionDecl)
        return self._valuetypes.field(member.type, member.initial, dataclass)

    def _nested(self, declaration: Declaration) -> list[str]:
        """Class attributes for nested declarations."""
        lines = []
        for inner in self._names.inside(declaration.name):
            local = self._local(inner)
            attribute = self._names.attribute(inner.name)
            # In a dataclass an annotation would make it a field.
            if isinstance(declaration, Interface) and not isinstance(inner, Const):
                attribute += f": {self.scope.TypeAlias}"
            lines.append(f"{attribute} = {local}")
            if isinstance(inner, Typedef):
                lines += self._nested_codec(inner, isinstance(declaration, Interface))
            if isinstance(inner, Enum):
                for member, attribute in self._names.enumerators(inner).items():
                    outside = self._names.attribute((*inner.name[:-1], member))
                    lines.append(f"{outside} = {local}.{attribute}")
        return lines

    def _contested(self, declaration: Interface) -> dict[str, str]:
        """The statement for each attribute that differs between bases."""
        py = self.scope
        lines = {}
        for attribute, inner in self._names.contested(declaration).items():
            value = py.reference(inner.name)
            if isinstance(inner, Enum) and attribute != self._names.attribute(
                inner.name
            ):
                members = self._names.enumerators(inner)
                names = {
                    self._names.attribute((*inner.name[:-1], member)): member
                    for member in members
                }
                value += f".{members[names[attribute]]}"
                lines[attribute] = f"{attribute}: {py.Any} = {value}"
            elif isinstance(inner, Const):
                lines[attribute] = f"{attribute}: {py.Any} = {value}"
            else:
                lines[attribute] = f"{attribute}: {py.TypeAlias} = {value}"
            if (
                isinstance(inner, Typedef)
                and inner.name not in self._late
                and self.has_codec(inner)
            ):
                codec = self._names.public_companion(inner.name, "Codec")
                value = py.companion(inner.name, "Codec")
                lines[codec] = f"{codec}: {py.TypeAlias} = {value}"
        return lines

    def _nested_codec(self, alias: Typedef, in_interface: bool) -> list[str]:
        """The class attribute for the codec of an alias; a codec defined later is assigned then."""
        outside = self._names.public_companion(alias.name, "Codec")
        local = self._names.companion(alias.name, "Codec")
        if alias.name in self.codecs:
            annotation = f": {self.scope.TypeAlias}" if in_interface else ""
            return [f"{outside}{annotation} = {local}"]
        if not self.has_codec(alias):
            return []
        self._late[alias.name] = outside
        return [f"{outside}: {self.scope.ClassVar}[{self.scope.type}[{local}]]"]

    # Unions, enums, constants, aliases.

    def _union(self, declaration: Union) -> str:
        version = self._version(declaration)
        variables = self._unions.values(declaration, self._mapping, version)
        case = selected(self._model, declaration)
        value = "None"
        if case is not None and not self._types.is_unset(declaration, case):
            several = "|" in str(variables["value_type"])
            value = self._union_value(case, several)
        return render(
            "types/union.py.j2",
            py=self.scope,
            name=self._local(declaration),
            options=self._options(declaration),
            docstring=self._doc(declaration),
            attributes=self._nested(declaration),
            value=value,
            **variables,
        )

    def _union_value(self, case: Case, several: bool) -> str:
        """Return the initial value of a union; `several`: it can be of several types."""
        initial = self._valuetypes.initial
        if not several or initial.is_inferred(case.type):
            field = self._valuetypes.field(case.type, case.initial, False)
            return field.partition(" = ")[2]
        # Type checkers do not infer the elements from one type of several.
        annotation = string_literal(self._mapping.annotation(case.type))
        value = initial.expression(case.type, case.initial)
        value = f"{self.scope.cast}({annotation}, {value})"
        return f"{self.scope.field}(default_factory=lambda: {value})"

    def _enum(self, declaration: Enum | Bitmask) -> str:
        names = self._names.enumerators(declaration)
        is_enum = isinstance(declaration, Enum)
        members = [
            Statement(
                f"{names[m.name]} = {m.value if is_enum else f'1 << {m.value}'}",
                docstring(m.doc, 4),
            )
            for m in declaration.members
        ]
        return render(
            "types/enum.py.j2",
            py=self.scope,
            name=self._local(declaration),
            base=self.scope.Enumeration if is_enum else self.scope.Flags,
            docstring=self._doc(declaration),
            members=members,
            descriptor=self._describe.enum(declaration, self._local(declaration)),
        )

    def _bitset(self, declaration: Bitset) -> str:
        names = self._names.members(declaration)
        fields = []
        for field in declaration.members:
            if field.name is not None:
                is_bool = is_boolean(self._model, field)
                kind = self.scope.bool if is_bool else self.scope.int
                zero = False if is_bool else 0
                value = zero if field.initial is None else field.initial
                text = f"{names[field.name]}: {kind} = {value}"
                fields.append(Statement(text, docstring(member_text(field), 4)))
        base = declaration.base
        return render(
            "types/struct.py.j2",
            py=self.scope,
            decorator="",
            name=self._local(declaration),
            bases=f"{self.scope.reference(base) if base else self.scope.Bitset}, frozen=True",
            docstring=self._doc(declaration),
            descriptor=self._describe.bitset(declaration),
            nested=(),
            fields=fields,
        )

    def _const(self, declaration: Const) -> str:
        name = self._local(declaration)
        value = self._constant(declaration.value)
        doc = docstring(member_text(declaration), 0)
        return f"{name}: {self.scope.Final} = {value}\n{doc}"

    def _constant(self, value: ConstantValue) -> str:
        match value:
            case EnumeratorName(name):
                enum, member = self._names.enumerator(name)
                return f"{self.scope.reference(enum)}.{member}"
            case str():
                return string_literal(value)
            case Decimal():
                return f'{self.scope.Decimal}("{value}")'
            case float() if not isfinite(value):
                return f'float("{value}")'
        return number_literal(value)

    def _alias(self, declaration: Typedef) -> str:
        annotation = self._mapping.annotation(declaration.type)
        name = self._local(declaration)
        if self._is_ahead(declaration.type):
            annotation = f'"{annotation}"'
        doc = docstring(member_text(declaration), 0)
        if not self._calls.marshalled and self._is_inside_interface(declaration):
            return f"{name}: {self.scope.TypeAlias} = {annotation}\n{doc}"
        described = self._describe.alias(
            declaration, self._alias_representation(declaration)
        )
        descriptor = f"{self.scope.alias(declaration.name)} = {described}"
        return f"{name}: {self.scope.TypeAlias} = {annotation}\n{doc}{descriptor}\n"

    def _alias_representation(self, declaration: Typedef) -> int:
        """The version of XCDR of a typedef's codec; 0 for classic CDR."""
        headers = self._types.has_headers(declaration.type)
        version = 2 if self._representations.are_xcdr2 else int(headers)
        if version and self._representations.missing(declaration.type):
            version = 0
        return version

    def _is_inside_interface(self, declaration: Declaration) -> bool:
        holder = declaration.name[:-1]
        return bool(holder) and any(
            isinstance(d, Interface) and d.name == holder
            for d in self._names.declarations(self._module)
        )

    def _is_ahead(self, type_: Type, through_aliases: bool = False) -> bool:
        """Whether the type refers to a class that is defined later in this module."""
        if through_aliases:
            type_ = self._model.unalias(type_)
        match type_:
            case SequenceType(element) | ArrayType(element):
                return self._is_ahead(element, through_aliases)
            case MapType(key, value):
                ahead = self._is_ahead(key, through_aliases)
                return ahead or self._is_ahead(value, through_aliases)
        name = getattr(type_, "name", None)
        if name is None or not is_emitted(self._model.find(name)):
            return False
        home, local = self._names.implementation(name)
        return home == self._home and local not in self._done

    def _ready_codecs(self) -> list[Block]:
        """The codecs of aliases whose types are already defined."""
        if not self._waiting:
            return []
        ready = [
            alias for alias in self._waiting if not self._is_ahead(alias.type, True)
        ]
        self._waiting = [alias for alias in self._waiting if alias not in ready]
        return [Block(text) for alias in ready if (text := self._codec(alias))]

    def has_codec(self, declaration: Typedef) -> bool:
        """Return whether a typedef has its own codec."""
        if not self._calls.marshalled:
            return False
        plain = self._model.unalias(declaration.type)
        if not isinstance(plain, SequenceType | ArrayType | MapType):
            return False
        try:
            self._types.check(plain)
        except NotMarshalledError:
            return False
        return True

    def _codec(self, declaration: Typedef) -> str:
        if not self.has_codec(declaration):
            return ""
        self.codecs.add(declaration.name)
        name = self._names.companion(declaration.name, "Codec")
        text = render(
            "types/codec.py.j2",
            py=self.scope,
            name=name,
            scoped=declaration.scoped,
            descriptor=self.scope.alias(declaration.name),
            type=self._local(declaration),
        )
        if declaration.name in self._late:
            holder = self._names.implementation(declaration.name[:-1])[1]
            text += f"\n\n{holder}.{self._late[declaration.name]} = {name}\n"
        return text
